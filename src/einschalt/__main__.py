"""``python -m einschalt`` is the command line."""

from einschalt.interfaces.cli.main import run

if __name__ == "__main__":
    run()

"""The process of a run that is killed in the midst of an answer."""

import os
import signal
import sys

if __name__ == "__main__":
    sys.stdin.readline()
    sys.stdout.write('{"fraction": 0.5}\n{"fraction": 0.')
    sys.stdout.flush()
    os.kill(os.getpid(), signal.SIGKILL)

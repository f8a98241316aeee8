"""What could make two runs differ in their bytes."""

from importlib import import_module
from pathlib import Path

from numba.core.dispatcher import Dispatcher

THEORY = Path(__file__).parents[1] / "src" / "einschalt" / "theory"


def kernels():
    for path in sorted(THEORY.rglob("*.py")):
        stem = ".".join(path.relative_to(THEORY).with_suffix("").parts)
        module = import_module(f"einschalt.theory.{stem}".removesuffix(".__init__"))
        for name, value in vars(module).items():
            if isinstance(value, Dispatcher) and value.__module__ == module.__name__:
                yield f"{stem}.{name}", value


def test_kernels_with_free_sums_exist_once():
    """A callee that is not inlined exists twice, and free sums make the two differ.

    The run that compiles calls the one, the runs that load compiled code the other:
    the first run after an installation then had other last digits than the second.
    """
    free = {n: k for n, k in kernels() if k.targetoptions.get("fastmath")}
    assert free
    modules = {kernel.__module__ for kernel in free.values()}
    for name, kernel in kernels():
        if kernel.__module__ in modules:
            assert kernel.targetoptions.get("forceinline"), name

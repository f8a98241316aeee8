"""What kernels call of each other: taken over into the caller, and never run alone.

numba makes machine code of every function that it compiles, and optimises it with all
that it calls. For a part that is done for nothing: its caller takes over the code as it
was before, and does both with the whole.
"""

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class PartLibrary(JITCodeLibrary):
    """Code of a part, as its callers link it into their own."""

    def _optimize_final_module(self):
        """Leave that to the caller, which knows the whole."""

    def _finalize_final_module(self):
        """Make no machine code."""
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name):  # noqa: ARG002
        """Give none: nothing here can be run."""
        return 0

    @property
    def codegen(self):
        """What sets the environment of compiled functions: here none is run."""
        return self

    def set_env(self, env_name, env):
        """Set nothing."""


class PartCompiler(Compiler):
    """numba's compiler, which keeps the code of a part in a library of parts."""

    def __init__(self, typing, target, library, args, return_type, flags, places):
        """Take the place of a library of numba's own kind."""
        # numba names it after the function, which it does not know yet
        library = PartLibrary(target.codegen(), "part")
        super().__init__(typing, target, library, args, return_type, flags, places)

"""What kernels call of each other: taken over into the caller, and never run alone.

numba makes machine code of every function that it compiles, and optimises it with all
that it calls. For a part that is done for nothing: its caller takes over the code as it
was before, and does both with the whole.

numba has no words for that, so that methods are overridden which other versions may not
have: those that were not tried compile parts as they compile everything.
"""

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

TRIED = {(0, 68)}  # versions of numba, major and minor


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


def compiler_of_parts(version=None):
    """Give the compiler of parts, for a version of numba, major and minor."""
    version = numba.version_info.short if version is None else version
    return PartCompiler if version in TRIED else Compiler

"""LAPACK and BLAS inside compiled kernels, for matrices that lie in flat arrays.

numba's own ``np.linalg`` copies what it is given and knows neither triangles nor
updates in place. scipy brings LAPACK and BLAS along (``scipy.linalg.cython_lapack``);
here they are called directly, for real and for complex numbers by the type of the
array. Matrices are stored column by column with a leading dimension, as LAPACK has
them; only lower triangles are read and written where a matrix is Hermitian. Only
compiled code can call these functions: in Python they do nothing.
"""

# ruff: noqa: ARG001 - numba looks at the names of the arguments, not at their use
import llvmlite.binding
import numpy as np
from numba import types
from numba.extending import get_cython_function_address, overload

# the pointers that each routine takes
_LAPACK = {"potrf": 5, "potri": 5}
_BLAS = {"trsm": 11, "syrk": 10, "herk": 10, "symm": 12, "hemm": 12, "gemm": 13}
_BLAS |= {"trsv": 8, "gemv": 11}
_PREFIX = "einschalt_"


def _external(name):
    """One routine of LAPACK or BLAS as a function that compiled code may call."""
    routine = name[1:]
    home = "lapack" if routine in _LAPACK else "blas"
    address = get_cython_function_address(f"scipy.linalg.cython_{home}", name)
    # by name, so that compiled code can be cached: addresses change with every start
    llvmlite.binding.add_symbol(_PREFIX + name, address)
    signature = types.void(*[types.voidptr] * (_LAPACK | _BLAS)[routine])
    return types.ExternalFunction(_PREFIX + name, signature)


_dpotrf, _zpotrf = _external("dpotrf"), _external("zpotrf")
_dpotri, _zpotri = _external("dpotri"), _external("zpotri")
_dtrsm, _ztrsm = _external("dtrsm"), _external("ztrsm")
_dsyrk, _zherk = _external("dsyrk"), _external("zherk")
_dsymm, _zhemm = _external("dsymm"), _external("zhemm")
_dgemm, _zgemm = _external("dgemm"), _external("zgemm")
_dtrsv, _ztrsv = _external("dtrsv"), _external("ztrsv")
_dgemv, _zgemv = _external("dgemv"), _external("zgemv")

_LETTERS = np.frombuffer(b"LRNC", dtype=np.uint8).copy()
# places in these letters; L stands for the left side and for the lower triangle
LEFT, RIGHT, PLAIN, ADJOINT = range(4)


def work_arrays(dtype):
    """Letters, integers and factors that the routines read through pointers.

    Eight integers; the factors 1, −1, 0 of the type (float64 or complex128) and as
    reals.
    """
    factors = np.array([1.0, -1.0, 0.0], dtype=dtype)
    return _LETTERS, np.zeros(8, np.int32), factors, np.array([1.0, -1.0, 0.0])


def _pick(array, real, complex_):
    return complex_ if array.dtype == types.complex128 else real


def factor_lower(a, n, lda, work):
    """Cholesky factor of ``a``, lower triangle, in place; 0, or the first bad pivot."""


@overload(factor_lower)
def _overload_factor_lower(a, n, lda, work):
    return _in_place(_pick(a, _dpotrf, _zpotrf))


def invert_lower(a, n, lda, work):
    """Lower triangle of (L Lᴴ)⁻¹ in place of L."""


@overload(invert_lower)
def _overload_invert_lower(a, n, lda, work):
    return _in_place(_pick(a, _dpotri, _zpotri))


def _in_place(routine):
    """Call of a routine that works on one lower triangle; it gives what went wrong."""

    def call(a, n, lda, work):
        letters, sizes, _, _ = work
        sizes[0], sizes[1], sizes[2] = n, lda, 0
        routine(
            letters[0:].ctypes,
            sizes[0:].ctypes,
            a.ctypes,
            sizes[1:].ctypes,
            sizes[2:].ctypes,
        )
        return sizes[2]

    return call


def solve_triangle(side, transposed, shape, triangle, ldt, b, ldb, work):
    """B := op(L)⁻¹ B (LEFT) or B op(L)⁻¹ (RIGHT), in place; op PLAIN or ADJOINT."""


@overload(solve_triangle)
def _overload_solve(side, transposed, shape, triangle, ldt, b, ldb, work):
    routine = _pick(b, _dtrsm, _ztrsm)

    def solve(side, transposed, shape, triangle, ldt, b, ldb, work):
        letters, sizes, factors, _ = work
        sizes[0], sizes[1], sizes[2], sizes[3] = shape[0], shape[1], ldt, ldb
        routine(
            letters[side:].ctypes,
            letters[0:].ctypes,
            letters[transposed:].ctypes,
            letters[2:].ctypes,
            sizes[0:].ctypes,
            sizes[1:].ctypes,
            factors[0:].ctypes,
            triangle.ctypes,
            sizes[2:].ctypes,
            b.ctypes,
            sizes[3:].ctypes,
        )

    return solve


def subtract_square(x, m, k, ldx, c, ldc, work):
    """C := C − X Xᴴ, lower triangle; X has m rows and k columns."""


@overload(subtract_square)
def _overload_subtract_square(x, m, k, ldx, c, ldc, work):
    routine = _pick(x, _dsyrk, _zherk)

    def subtract(x, m, k, ldx, c, ldc, work):
        letters, sizes, _, reals = work
        sizes[0], sizes[1], sizes[2], sizes[3] = m, k, ldx, ldc
        routine(
            letters[0:].ctypes,
            letters[2:].ctypes,
            sizes[0:].ctypes,
            sizes[1:].ctypes,
            reals[1:].ctypes,
            x.ctypes,
            sizes[2:].ctypes,
            reals[0:].ctypes,
            c.ctypes,
            sizes[3:].ctypes,
        )

    return subtract


def multiply_hermitian(a, lda, b, ldb, c, ldc, shape, work):
    """C := −A B with the lower triangle of a Hermitian A; ``shape`` is that of B."""


@overload(multiply_hermitian)
def _overload_multiply_hermitian(a, lda, b, ldb, c, ldc, shape, work):
    routine = _pick(a, _dsymm, _zhemm)

    def multiply(a, lda, b, ldb, c, ldc, shape, work):
        letters, sizes, factors, _ = work
        sizes[0], sizes[1] = shape[0], shape[1]
        sizes[2], sizes[3], sizes[4] = lda, ldb, ldc
        routine(
            letters[0:].ctypes,
            letters[0:].ctypes,
            sizes[0:].ctypes,
            sizes[1:].ctypes,
            factors[1:].ctypes,
            a.ctypes,
            sizes[2:].ctypes,
            b.ctypes,
            sizes[3:].ctypes,
            factors[2:].ctypes,
            c.ctypes,
            sizes[4:].ctypes,
        )

    return multiply


def subtract_product(transposed, a, lda, b, ldb, c, ldc, shape, work):
    """C := C − op(A) B; ``shape``: rows and columns of C, and the inner length."""


@overload(subtract_product)
def _overload_subtract_product(transposed, a, lda, b, ldb, c, ldc, shape, work):
    routine = _pick(a, _dgemm, _zgemm)

    def subtract(transposed, a, lda, b, ldb, c, ldc, shape, work):
        letters, sizes, factors, _ = work
        sizes[0], sizes[1], sizes[2] = shape[0], shape[1], shape[2]
        sizes[3], sizes[4], sizes[5] = lda, ldb, ldc
        routine(
            letters[transposed:].ctypes,
            letters[2:].ctypes,
            sizes[0:].ctypes,
            sizes[1:].ctypes,
            sizes[2:].ctypes,
            factors[1:].ctypes,
            a.ctypes,
            sizes[3:].ctypes,
            b.ctypes,
            sizes[4:].ctypes,
            factors[0:].ctypes,
            c.ctypes,
            sizes[5:].ctypes,
        )

    return subtract


def solve_triangle_vector(transposed, n, triangle, ldt, b, work):
    """Replace a vector b by op(L)⁻¹ b; op PLAIN or ADJOINT."""


@overload(solve_triangle_vector)
def _overload_solve_vector(transposed, n, triangle, ldt, b, work):
    routine = _pick(b, _dtrsv, _ztrsv)

    def solve(transposed, n, triangle, ldt, b, work):
        letters, sizes, _, _ = work
        sizes[0], sizes[1], sizes[2] = n, ldt, 1
        routine(
            letters[0:].ctypes,
            letters[transposed:].ctypes,
            letters[2:].ctypes,
            sizes[0:].ctypes,
            triangle.ctypes,
            sizes[1:].ctypes,
            b.ctypes,
            sizes[2:].ctypes,
        )

    return solve


def subtract_matrix_vector(transposed, shape, a, lda, x, y, work):
    """Replace a vector y by y − op(A) x; ``shape`` is that of A."""


@overload(subtract_matrix_vector)
def _overload_subtract_matrix_vector(transposed, shape, a, lda, x, y, work):
    routine = _pick(a, _dgemv, _zgemv)

    def subtract(transposed, shape, a, lda, x, y, work):
        letters, sizes, factors, _ = work
        sizes[0], sizes[1], sizes[2], sizes[3] = shape[0], shape[1], lda, 1
        routine(
            letters[transposed:].ctypes,
            sizes[0:].ctypes,
            sizes[1:].ctypes,
            factors[1:].ctypes,
            a.ctypes,
            sizes[2:].ctypes,
            x.ctypes,
            sizes[3:].ctypes,
            factors[0:].ctypes,
            y.ctypes,
            sizes[3:].ctypes,
        )

    return subtract

"""Whether a MATLAB file of version 5 to 7 holds together, before scipy reads it.

scipy's `VarReader5.read_numeric` and `read_char` take the type that an element states as an index into a short array of
pointers without looking whether it is in there, so a damaged type, or a matrix that lacks a part and so takes the next
matrix for its numbers, ends the whole program with a segmentation fault (scipy 1.17; its pull request 25829 is to mend
it). This file can go once no damaged file of the tests does so without it.

The format: MathWorks, MAT-File Format (2023), "Version 5 MAT-File Format".
"""

import math
import struct
import zlib
from collections.abc import Iterator

LEAVES = {*range(1, 8), 9, 12, 13, 16, 17, 18}
"""Types of an element that holds numbers or text."""
MATRIX, COMPRESSED, UINT32 = 14, 15, 6
CELL, STRUCT, OBJECT, CHAR, SPARSE, FUNCTION, OPAQUE = 1, 2, 3, 4, 5, 16, 17
NUMERIC = range(6, 16)
"""Classes of a matrix."""
COMPLEX = 0x800
DEEPEST = 50
"""Structs within structs; the reader's own limit is the stack."""


def check_elements(content: bytes) -> None:
    """Raises ValueError where an element of a file's `content` ends beyond the one around it, is of no known type, or
    a matrix has not as many parts as its class and size ask for."""
    order = ">" if content[126:128] == b"MI" else "<"
    for kind, data in _elements(memoryview(content)[128:], order):
        if kind == COMPRESSED:
            try:
                inside = list(_elements(memoryview(zlib.decompress(data)), order))
            except zlib.error as error:
                raise ValueError(f"a damaged compressed element: {error}") from None
            _demand(len(inside) == 1, "a compressed element of other than one matrix")
            kind, data = inside[0]
        _demand(kind == MATRIX, f"an element of type {kind} where a matrix was expected")
        _check_matrix(data, order, DEEPEST)


def _demand(right: bool, otherwise: str) -> None:
    if not right:
        raise ValueError(otherwise)


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Type and content of each element. Of a short one, of up to 4 bytes, the upper half of the type is its size."""
    at = 0
    while at < len(data):
        _demand(len(data) - at >= 8, "an element that is cut off")
        kind, size = struct.unpack_from(order + "II", data, at)
        begin = at + 8
        if kind >> 16:
            kind, size, begin = kind & 0xFFFF, kind >> 16, at + 4
            _demand(size <= 4, "a short element of more than 4 bytes")
        _demand(begin + size <= len(data), "an element that ends beyond the one around it")
        yield kind, data[begin : begin + size]
        at = max(begin + size, at + 8)
        if kind in LEAVES:
            at += -at % 8


def _check_matrix(data: memoryview, order: str, depth: int) -> None:
    _demand(depth > 0, f"structs or cells nested more than {DEEPEST} deep")
    if not data:
        return
    parts = list(_elements(data, order))
    _demand(parts[0][0] == UINT32 and len(parts[0][1]) == 8, "a matrix without its class")
    flags = struct.unpack_from(order + "I", parts[0][1])[0]
    leaves, matrices = _parts(flags, [part for _, part in parts[1:6]], order)
    kinds = [kind for kind, _ in parts[1:]]
    right = len(kinds) == leaves + matrices and LEAVES.issuperset(kinds[:leaves])
    _demand(right and all(kind == MATRIX for kind in kinds[leaves:]), "a matrix with other parts than its class has")
    for _, part in parts[1 + leaves :]:
        _check_matrix(part, order, depth - 1)


def _parts(flags: int, first: list[memoryview], order: str) -> tuple[int, int]:
    """How many leaves and how many matrices follow the flags of a matrix: the leaves are size and name, then numbers
    or the names of fields. `first` are the first of them."""
    kind, twice = flags & 0xFF, bool(flags & COMPLEX)
    if kind == OPAQUE:
        return 3, 1
    _demand(len(first) >= 2, "a matrix without size and name")
    _demand(len(first[0]) % 4 == 0, "a matrix of no size")
    n = math.prod(struct.unpack(f"{order}{len(first[0]) // 4}i", first[0]))
    if kind in (STRUCT, OBJECT):
        before = 3 if kind == OBJECT else 2
        _demand(len(first) >= before + 2 and len(first[before]) == 4, "a struct without fields")
        length = struct.unpack(order + "i", first[before])[0]
        _demand(length > 0, "names of fields that have no length")
        return before + 2, n * (len(first[before + 1]) // length)
    known = {CELL: (2, n), FUNCTION: (2, 1), CHAR: (3, 0), SPARSE: (5 + twice, 0)}
    _demand(kind in known or kind in NUMERIC, f"a matrix of unknown class {kind}")
    return known.get(kind, (3 + twice, 0))

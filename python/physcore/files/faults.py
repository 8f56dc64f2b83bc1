"""Places where a mesh is not closed."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray, IntArray


def fault_of(vertices: FloatArray, faces: IntArray) -> str | None:
    """The first edge that does not belong to two faces which pass it in opposite directions, as a sentence.

    None if there is none.
    """

    def place(edge: IntArray) -> str:
        middle = vertices[edge].mean(axis=0)
        return f"of the vertices {edge[0]} and {edge[1]}, at ({', '.join(f'{x:.4g}' for x in middle)}) m"

    directed = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges, inverse, counts = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    many, single = counts > 2, counts == 1
    if many.any():
        edge = int(np.argmax(many))
        return f"{counts[edge]} faces meet at the edge {place(edges[edge])}"
    if single.any():
        first = edges[np.argmax(single)]
        return f"it is open: {np.count_nonzero(single)} edges have one face only, the first {place(first)}"
    forward = np.bincount(inverse.ravel(), weights=directed[:, 0] < directed[:, 1], minlength=len(edges))
    if (forward != 1.0).any():
        first = edges[np.argmax(forward != 1.0)]
        return f"two faces pass the edge {place(first)} in one direction, so that one of them is turned over"
    return None

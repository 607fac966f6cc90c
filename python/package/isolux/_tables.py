"""Columns as numpy structured arrays, and those as tables of other packages."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Sequence, Tuple, Union

import numpy as np

Columns = Mapping[str, Union[np.ndarray, Sequence[Any]]]


def structured(columns: Columns) -> np.ndarray:
    """One record a row: a field for each column, text as unicode, columns of rows with a shape of their own."""
    arrays = {name: np.asarray(column) for name, column in columns.items()}
    arrays = {name: array for name, array in arrays.items() if array.dtype != object}
    fields: List[Tuple[Any, ...]] = [
        (name, "U1" if array.dtype.itemsize == 0 else array.dtype, array.shape[1:]) for name, array in arrays.items()
    ]
    length = max((len(array) for array in arrays.values()), default=0)
    table = np.empty(length, dtype=fields)
    for name, array in arrays.items():
        table[name] = array
    return table


#: Columns of a record that hold bytes in hexadecimal, which may look like numbers.
HEXADECIMAL = ("raw", "chain", "row_crc")


def read_back(name: str, texts: Sequence[str]) -> np.ndarray:
    """A column of texts as numbers where every one of them is a number or empty (NaN), else as texts."""
    if name in HEXADECIMAL:
        return np.array(texts, dtype=str)
    try:
        return np.array([float(text) if text else np.nan for text in texts], dtype=float)
    except ValueError:
        return np.array(texts, dtype=str)


def one_dimensional(table: np.ndarray) -> Dict[str, np.ndarray]:
    """The fields of a structured array that hold one value a row."""
    assert table.dtype.names is not None
    return {name: table[name] for name in table.dtype.names if table[name].ndim == 1}

"""Foreign programs that read and write Nastran's files: pyNastran, or pyYeti where numpy is 2."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class LabelledMatrix:
    """A matrix and the (point, component) of its rows and columns; empty ones may be left out."""

    values: Any
    rows: list
    columns: list


@dataclass(frozen=True, kw_only=True, eq=False)
class BulkModel:
    """What a foreign program understood of bulk data."""

    grids: dict
    scalar_points: set
    matrices: dict
    constraints: int


class PyNastran:
    """pyNastran; version 1.4 needs numpy 1."""

    def bulk(self, path):
        model = self._model(path)
        matrices = {}
        for name, entry in model.dmig.items():
            if len(entry.GCi) == 0:
                continue  # it has no form for a matrix of zeros
            values, by_row, by_column = entry.get_matrix()
            rows = [_label(by_row[k]) for k in sorted(by_row)]
            # a rectangle's columns have no components
            plain = name == "RIGB"
            columns = [] if plain else [_label(by_column[k]) for k in sorted(by_column)]
            matrices[name] = LabelledMatrix(values=values, rows=rows, columns=columns)
        return BulkModel(
            grids={int(k): np.asarray(grid.xyz) for k, grid in model.nodes.items()},
            scalar_points=set(model.spoints),
            matrices=matrices,
            constraints=sum(len(listed) for listed in model.mpcs.values()),
        )

    def bulk_again(self, path, to):
        """Write bulk data anew, in 16 columns and pyNastran's own number format."""
        self._model(path).write_bdf(str(to), size=16, is_double=True, interspersed=False)

    def real(self, text):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            from pyNastran.bdf.bdf_interface.assign_type import double
            from pyNastran.bdf.bdf_interface.bdf_card import BDFCard
        return double(BDFCard(["X", text.strip()]), 1, "value")

    def op4(self, path):
        with warnings.catch_warnings():
            # its own use of numpy, nothing of the file
            warnings.simplefilter("ignore", DeprecationWarning)
            from pyNastran.op4.op4 import OP4

            found = OP4(debug=None, log=None).read_op4(str(path))
        matrices = {}
        for name, value in found.items():
            form, matrix = value if isinstance(value, tuple) else (value.form, value.data)
            matrices[name] = (int(form), np.asarray(matrix))
        return matrices

    def write_op4(self, path, matrices):
        """Write ASCII; the binary writer is broken in 1.4.1."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            from pyNastran.op4.op4 import OP4

            OP4(debug=None, log=None).write_op4(str(path), matrices, is_binary=False)

    def _model(self, path):
        with warnings.catch_warnings():
            # its own use of numpy and of the standard library, nothing of the file
            warnings.simplefilter("ignore", DeprecationWarning)
            from pyNastran.bdf.bdf import BDF

            model = BDF(debug=None, log=None)
            model.read_bdf(str(path), punch=True, xref=False)
        return model


class PyYeti:
    """pyYeti, which allows numpy 2."""

    def bulk(self, path):
        bulk = self._module("bulk")
        matrices = {}
        for name, table in bulk.rddmig(str(path)).items():
            plain = table.columns.nlevels == 1
            columns = [] if plain else [_label(v) for v in table.columns]
            rows = [_label(v) for v in table.index]
            matrices[name.upper()] = LabelledMatrix(
                values=table.to_numpy(), rows=rows, columns=columns
            )
        grids = bulk.rdgrids(str(path))
        constraints = bulk.rdcards(str(path), "mpc", return_var="list", no_data_return=[])
        return BulkModel(
            grids={int(row[0]): row[2:5] for row in grids},
            scalar_points={int(v) for v in bulk.rdspoints(str(path))},
            matrices=matrices,
            constraints=len(constraints),
        )

    def bulk_again(self, path, to):
        """Write grids, scalar points and matrices anew, in pyYeti's own number format."""
        bulk = self._module("bulk")
        grids = bulk.rdgrids(str(path))
        with to.open("w", encoding="ascii") as file:
            bulk.wtgrids(file, grids[:, 0].astype(int), xyz=grids[:, 2:5], form="{:16.9E}")
            bulk.wtspoints(file, bulk.rdspoints(str(path)))
            bulk.wtdmig(file, {k.upper(): v for k, v in bulk.rddmig(str(path)).items()})

    def real(self, text):
        return self._module("bulk").nas_sscanf(text)

    def op4(self, path):
        found = self._module("op4").load(str(path), justmatrix=False)
        return {name.upper(): (form, values) for name, (values, form, _) in found.items()}

    def write_op4(self, path, matrices):
        """Write ASCII with all digits."""
        listed = {name: (values, form) for name, (form, values) in matrices.items()}
        self._module("op4").write(str(path), listed, binary=False, digits=17)

    def _module(self, name):
        with warnings.catch_warnings():
            # of its own use of pandas and matplotlib
            warnings.simplefilter("ignore")
            from pyyeti.nastran import bulk, op4
        return {"bulk": bulk, "op4": op4}[name]


def _label(key):
    return tuple(int(v) for v in key)


def nastran_reader() -> PyNastran | PyYeti:
    """The foreign program that is installed: pyNastran on Python 3.11 and 3.12, else pyYeti."""
    return PyNastran() if find_spec("pyNastran") else PyYeti()

"""An assembled system as operators that never couple: smaller problems with the same roots."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.operator import SpeedLaw, operator_of
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, IntArray, Matrix
from solidwhirl.rotordyn.core.dense import uncoupled
from solidwhirl.rotordyn.core.second_order import Joint, SecondOrder, Term
from solidwhirl.rotordyn.modes.complex_form import ComplexForm, complex_form, lateral_parts


class OperatorBlock(NamedTuple):
    """Motions of a system that couple with no others.

    `operator`: of its k coordinates; `lift`: the independent coordinates are lift · x, (n, k). A
    complex block stands for the conjugate roots and vectors as well.
    """

    operator: SecondOrder
    lift: Matrix


@lru_cache(maxsize=16)
def operator_blocks(assembled: AssembledSystem) -> tuple[OperatorBlock, ...]:
    """Return a system as operators that have all its roots together.

    Where it is the same in all directions lateral motion is x + i y, half as many coordinates; what
    no matrix joins is apart. With bearings over the frequency and controllers the system is one.
    """
    operator, everything = operator_of(assembled), np.arange(assembled.size)
    if assembled.depends_on_frequency:
        states = np.zeros((assembled.size, operator.states))
        return (OperatorBlock(operator, np.hstack((np.eye(assembled.size), states))),)
    form = complex_form(assembled)
    if form is None:
        return tuple(_real_block(operator, group) for group in _apart(operator, everything))
    lateral = [_lateral_block(form.part(group)) for group in lateral_parts(form)]
    rest = [_real_block(operator, group) for group in _apart(operator, form.rest)]
    return (*lateral, *rest)


def _apart(operator: SecondOrder, among: IntArray) -> list[IntArray]:
    """Return the groups of some coordinates that no entry of any matrix joins."""
    joined = [term.matrix[np.ix_(among, among)] for term in operator.terms]
    motions = [joint.rows[:, among] for joint in operator.joints]
    return [among[group] for group in uncoupled(*joined, motions=motions)]


def _real_block(operator: SecondOrder, group: IntArray) -> OperatorBlock:
    block = np.ix_(group, group)
    terms = [term._replace(matrix=term.matrix[block]) for term in operator.terms]
    joints = [joint._replace(rows=joint.rows[:, group]) for joint in operator.joints]
    return OperatorBlock(
        SecondOrder(_of_value(terms), tuple(joint for joint in joints if joint.rows.any())),
        np.eye(operator.size)[:, group],
    )


def _lateral_block(form: ComplexForm) -> OperatorBlock:
    terms = (
        # complex, though it may be real: its roots of either sign are two motions
        Term(0, form.mass.astype(complex)),
        Term(1, form.damping),
        Term(1, -1j * form.gyroscopic, 1),
        Term(2, form.stiffness),
        Term(2, -1j * form.circulatory, 1),
        Term(2, form.centrifugal_stiffness, 2),
    )
    # x and y of a bearing on a circle x + i y: of each half of its stiffness
    joints = tuple(
        Joint(
            np.array([law.motion, -1j * law.motion]) / np.sqrt(2.0),
            SpeedLaw(form.assembled.law_joints[law.place]),
        )
        for law in form.laws
    )
    lift: ComplexArray = np.zeros((form.assembled.size, form.size), dtype=complex)
    lift[form.first, np.arange(form.size)] = 1.0
    lift[form.second, np.arange(form.size)] = -1j * form.second_sign
    return OperatorBlock(SecondOrder(_of_value(terms), joints), lift)


def _of_value(terms: tuple[Term, ...] | list[Term]) -> tuple[Term, ...]:
    first, *others = terms
    return (first, *(term for term in others if term.matrix.any()))

"""Which cases may run beside others: their predicted memory against what the nodes have free."""

from __future__ import annotations

from collections.abc import Mapping, Sequence


class MemoryRoom:
    """Memory of the nodes, divided among the teams that compute on them.

    A team computes one case at a time: of the cases that it was given, the largest counts. A team
    on several nodes takes of each as much as it has of its ranks there.

    Parameters
    ----------
    free_gib
        Free memory by node, before the first case [GiB].
    shares
        By team: node and part of the team's ranks that are there; the parts add up to 1.
    needs_gib
        Predicted peak memory by case [GiB]; a case that is not in it needs none.
    """

    def __init__(
        self,
        free_gib: Mapping[str, float],
        shares: Sequence[Mapping[str, float]],
        needs_gib: Mapping[int, float],
    ) -> None:
        self._free, self._shares, self._needs = dict(free_gib), tuple(shares), dict(needs_gib)
        self._given: tuple[set[int], ...] = tuple(set() for _ in shares)

    def may_begin(self, team: int, case: int) -> bool:
        """Whether a team may begin a case now.

        It may if the case fits beside what the other teams were given. One that fits nowhere, ever,
        runs alone: whether that can be done is for the case itself to say.

        Parameters
        ----------
        team, case
            Their indices.
        """
        beside = {node: self._taken(node, team) for node in self._shares[team]}
        need = max(self.need_gib(case), self._largest(team))
        if self._fits(team, need, beside):
            return True
        return not self.ever_fits(case) and not any(beside.values())

    def ever_fits(self, case: int) -> bool:
        """Whether there is a team that could compute a case if nothing else ran.

        Parameters
        ----------
        case
            Its index.
        """
        need = self.need_gib(case)
        return any(self._fits(team, need, {}) for team in range(len(self._shares)))

    def need_gib(self, case: int) -> float:
        """Predicted memory of a case [GiB].

        Parameters
        ----------
        case
            Its index.
        """
        return self._needs.get(case, 0.0)

    def begin(self, team: int, case: int) -> None:
        """Write down that a team was given a case.

        Parameters
        ----------
        team, case
            Their indices.
        """
        self._given[team].add(case)

    def end(self, case: int) -> None:
        """Write down that a case is over.

        Parameters
        ----------
        case
            Its index.
        """
        for given in self._given:
            given.discard(case)

    def _fits(self, team: int, need: float, beside: Mapping[str, float]) -> bool:
        return all(
            beside.get(node, 0.0) + part * need <= self._free[node]
            for node, part in self._shares[team].items()
        )

    def _taken(self, node: str, without: int) -> float:
        """Memory of a node that teams other than one were given."""
        return sum(
            share.get(node, 0.0) * self._largest(team)
            for team, share in enumerate(self._shares)
            if team != without
        )

    def _largest(self, team: int) -> float:
        return max((self.need_gib(case) for case in self._given[team]), default=0.0)

"""Lists the packages: the stages lie on top of the tree and install inside `solidwhirl`."""

from setuptools import find_packages, setup

STAGES = ("geometry", "meshing", "reduction", "rotordyn")
program = find_packages(include=["solidwhirl", "solidwhirl.*"], exclude=[])
program = [p for p in program if p.split(".")[1:2] not in [[s] for s in STAGES]]
stages = [p for s in STAGES for p in (s, *(f"{s}.{q}" for q in find_packages(s)))]
setup(
    packages=[*program, *(f"solidwhirl.{p}" for p in stages)],
    package_dir={f"solidwhirl.{s}": s for s in STAGES},
)

"""Print pip constraints that keep the versions Debian compiled dolfinx and petsc4py against."""

from importlib.metadata import PackageNotFoundError, version

for name in ("numpy", "scipy", "mpi4py", "cffi", "petsc4py", "slepc4py"):
    try:
        print(f"{name}=={version(name)}")
    except PackageNotFoundError:
        continue

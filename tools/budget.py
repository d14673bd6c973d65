"""What the house weighs: lines of product and tests, modules per folder, long functions.

    .venv/bin/python tools/budget.py [--check]

Product is Python and JavaScript that is installed; docs, bench and tools are counted apart.
`--check` fails above the limits.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PRODUCT = ("geometry", "meshing", "reduction", "rotordyn", "solidwhirl")
LIMITS = {"product": 66_000, "tests": 42_000}
MOST_MODULES, MOST_LINES, MOST_PARAMETERS = 14, 60, 8


def main() -> int:
    """Print the figures; 1 if one is above its limit and `--check` is given."""
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    files = [Path(name) for name in listed.stdout.splitlines()]
    lines: Counter[str] = Counter()
    modules: Counter[Path] = Counter()
    long: list[str] = []
    for path in (p for p in files if p.suffix in (".py", ".js") and not (ROOT / p).is_symlink()):
        text = (ROOT / path).read_text(encoding="utf-8")
        group = "product" if path.parts[0] in PRODUCT else path.parts[0]
        lines[group] += len(text.splitlines())
        named = path.suffix == ".py" and path.name != "__init__.py"
        modules[path.parent] += named and group == "product"
        if path.suffix == ".py" and group == "product":
            long += [f"{path}:{found}" for found in _long_functions(ast.parse(text))]
    crowded = [f"{folder}: {n} modules" for folder, n in modules.items() if n > MOST_MODULES]
    for group, count in sorted(lines.items()):
        limit = LIMITS.get(group)
        print(f"{group:12} {count:7}" + (f" of {limit}" if limit else ""))
    print(f"folders above {MOST_MODULES} modules: {len(crowded)}", *crowded, sep="\n  ")
    print(f"functions above {MOST_LINES} lines or {MOST_PARAMETERS} parameters: {len(long)}")
    print(*(f"  {entry}" for entry in long), sep="\n")
    above = any(lines[group] > limit for group, limit in LIMITS.items())
    return int("--check" in sys.argv and bool(above or crowded or long))


def _long_functions(tree: ast.AST) -> Iterator[str]:
    """Line, name and size of functions above a limit; docstrings count as lines."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            size = (node.end_lineno or node.lineno) - node.lineno + 1
            given = node.args
            count = len(given.posonlyargs) + len(given.args) + len(given.kwonlyargs)
            count -= bool(given.args) and given.args[0].arg in ("self", "cls")
            if size > MOST_LINES or count > MOST_PARAMETERS:
                yield f"{node.lineno} {node.name}: {size} lines, {count} parameters"


if __name__ == "__main__":
    sys.exit(main())

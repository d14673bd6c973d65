"""Tables and goals of the comparison with other programs, from its JSON document."""

from __future__ import annotations

ONE_RPM = 10_000.0
FOUND_WITHIN = 0.02
REFERENCE_MESH = "graded, finer"


def at_speed(item: dict, rpm: float) -> list[float] | None:
    """Frequencies of an entry at a speed, None without them."""
    speeds = item.get("speed_rpm", [])
    places = [k for k, s in enumerate(speeds) if abs(s - rpm) < 1e-6 * ONE_RPM]
    return item["frequency_hz"][places[0]] if places else None


def largest_error(found: list[float], wanted: list[float]) -> float:
    """Largest relative distance of wanted frequencies from the nearest found."""
    return max(min(abs(f / w - 1.0) for f in found) for w in wanted)


def errors(item: dict, reference: dict) -> dict:
    """Errors of the first whirl pair, of all ten branches, and of the first bending at rest."""
    spinning, wanted = at_speed(item, ONE_RPM), at_speed(reference, ONE_RPM)
    rest = item.get("free_hz") or at_speed(item.get("rest", item), 0.0)
    return {
        "pair": largest_error(spinning, wanted[:2]) if spinning else None,
        "ten": largest_error(spinning, wanted) if spinning else None,
        "rest": largest_error(rest, reference["free_hz"][:1]) if rest else None,
    }


def percent(value: float | None) -> str:
    """Percentage with two digits, empty without a value."""
    return "" if value is None else f"{100.0 * value:.2g} %"


def seconds(value: float | None) -> str:
    """Seconds with three digits, empty without a value."""
    return "" if value is None else f"{value:.3g}" if value < 1000.0 else f"{value:.0f}"


def table(head: list[str], rows: list[list[str]]) -> str:
    """Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def diagram_rows(document: dict) -> list[dict]:
    """One row per program and model: unknowns, errors, CPU time of one speed and of 21, memory."""
    reference, meshes, rows = document["reference"], document["meshes"], []

    def add(program, model, unknowns, item, one, every, peak, how=""):
        cells = {"program": program, "model": model, "unknowns": unknowns, "one": one}
        cells |= {"every": every, "peak": peak, "how": how, **errors(item, reference)}
        rows.append(cells)

    for name, item in document["calculix"]["meshes"].items():
        size, cpu = meshes[name]["unknowns"], (item["cpu_s"], item["cpu_21_s"])
        add("CalculiX", name, size, item, *cpu, item["peak_gib"], item["how_21"])
    wheels = {"disk": "beam, rigid wheel", "steps": "beam, wheel as steps"}
    for wheel, item in document["ross"].items():
        peak = item["peak_gib"]
        add("ROSS", wheels[wheel], item["coordinates"], item, None, item["cpu_s"], peak)
    solid = document.get("solid", {"one": {}, "all": {}})
    for name, item in solid["all"].items():
        one = solid["one"][name]["cpu_s"]
        size, peak = meshes[name]["unknowns"], item["peak_gib"]
        add("sector of the mesh", name, size, item, one, item["cpu_s"], peak)
    for level, accuracies in document.get("accuracies", {}).items():
        for accuracy, item in accuracies.items():
            size, peak = item["unknowns"], item["peak_gib"]
            add(f"{level} level", f"accuracy {accuracy}", size, item, None, item["cpu_s"], peak)
    return rows


def diagram_table(document: dict) -> str:
    """Campbell diagrams; the ratio is that of CPU times for 21 speeds."""
    rows = diagram_rows(document)
    base = document["calculix"]["meshes"][REFERENCE_MESH]["cpu_21_s"]
    head = ["CalculiX, finer / this", "program", "model", "unknowns", "error of whirl pair"]
    head += ["of ten branches", "at rest", "CPU 1 speed [s]", "CPU 21 speeds [s]", "peak [GiB]"]
    lines = []
    for r in rows:
        every = seconds(r["every"]) + (f" ({r['how']})" if r["how"] else "")
        cells = [f"{base / r['every']:.3g}", r["program"], r["model"], str(r["unknowns"])]
        cells += [percent(r["pair"]), percent(r["ten"]), percent(r["rest"])]
        lines.append([*cells, seconds(r["one"]), every, f"{r['peak']:.2f}"])
    return table(head, lines)


def calculix_notes(document: dict) -> str:
    """What fewer modes would save, and what CalculiX's Newton iteration misses at low speeds."""
    reference, theirs = document["reference"], document["calculix"]
    fewer, whole = theirs["fewer_modes"], theirs["meshes"][REFERENCE_MESH]
    jobs = [m["jobs"]["all"] for m in theirs["meshes"].values() if "all" in m["jobs"]]
    missing = []
    for rpm, found in zip(jobs[0]["speed_rpm"], jobs[0]["frequency_hz"], strict=True):
        wanted = at_speed(reference, rpm) or []
        count = sum(largest_error(found, [w]) < FOUND_WITHIN for w in wanted)
        if count < len(wanted):
            missing.append(f"{rpm:.0f} rpm: {count}")
    return (
        f"CalculiX with {fewer['modes']} modes, {REFERENCE_MESH}, one speed: "
        f"{seconds(fewer['cpu_s'])} s instead of {seconds(whole['cpu_s'])} s. Speeds at which its "
        f"list holds fewer than ten branches within {100 * FOUND_WITHIN:g} %, and how many: "
        f"{', '.join(missing) or 'none'}.\n"
    )


def reduced_rows(document: dict) -> list[dict]:
    """Exudyn's reduction and ours by mesh."""
    reference, rows = document["reference"], []
    for name, theirs in document["exudyn"].items():
        listed = [("Exudyn", theirs, "no prestress, no gyroscopic terms, matrices given")]
        for motions, item in document.get("solid", {}).get("reduced", {}).get(name, {}).items():
            interfaces = {"six": "all motions, orders 0 and 1", "lateral": "lateral motions"}
            listed.append(("solid level", item, interfaces[motions]))
        for program, item, what in listed:
            rows.append(
                {
                    "mesh": name,
                    "unknowns": document["meshes"][name]["unknowns"],
                    "program": program,
                    "what": what,
                    "ratio": theirs["cpu_s"] / item["cpu_s"],
                    # the reduction alone, without loading matrices, against our whole process
                    "strict": theirs["reduction_cpu_s"] / item["cpu_s"],
                    "memory": theirs["peak_gib"] / item["peak_gib"],
                    "item": item,
                    "rest": errors(item, reference)["rest"],
                }
            )
    return rows


def reduced_table(document: dict) -> str:
    """Reduced bodies with two rigid interfaces and 20 modes."""
    head = ["Exudyn / this, CPU", "memory", "program", "mesh", "unknowns", "content", "coordinates"]
    head += ["CPU [s]", "peak [GiB]", "error at rest"]
    lines = []
    for r in reduced_rows(document):
        item = r["item"]
        cells = [f"{r['ratio']:.3g}", f"{r['memory']:.2g}", r["program"], r["mesh"]]
        cells += [str(r["unknowns"]), r["what"], str(item["coordinates"]), seconds(item["cpu_s"])]
        lines.append([*cells, f"{item['peak_gib']:.2f}", percent(r["rest"])])
    return table(head, lines)


def level_goal(document: dict, level: str) -> tuple[str, float, str, bool]:
    """The cheapest accuracy whose error is a third of CalculiX's on its finer graded mesh."""
    rows = diagram_rows(document)
    theirs = next(r for r in rows if (r["program"], r["model"]) == ("CalculiX", REFERENCE_MESH))
    ours = [r for r in rows if r["program"] == f"{level} level" and r["pair"] <= theirs["pair"] / 3]
    text = f"{level} level, 21 speeds, a third of CalculiX's error"
    if not ours:
        return text + " (no accuracy reaches it)", 0.0, "300", False
    best = min(ours, key=lambda r: r["every"])
    ratio = theirs["every"] / best["every"]
    return f"{text} ({best['model']})", ratio, "300", ratio >= 300.0


def goals(document: dict) -> list[tuple[str, float, str, bool]]:
    """Name, ratio, goal, and whether it is met."""
    found = [level_goal(document, level) for level in document["accuracies"]]
    for key, name, goal in (("one", "one speed", 5.0), ("all", "21 speeds", 50.0)):
        for mesh, ours in document["solid"][key].items():
            theirs = document["calculix"]["meshes"][mesh]["cpu_s" if key == "one" else "cpu_21_s"]
            ratio = theirs / ours["cpu_s"]
            text = f"sector, {name}, mesh of CalculiX: {mesh}"
            found.append((text, ratio, f"{goal:g}", ratio >= goal))
    for r in reduced_rows(document):
        if r["program"] != "Exudyn" and r["mesh"] == "even":
            text = f"reduced body, {r['what']}"
            found.append((f"{text}: CPU", r["ratio"], "10", r["ratio"] >= 10.0))
            found.append(
                (f"{text}: CPU, Exudyn without start-up", r["strict"], "10", r["strict"] >= 10.0)
            )
            found.append((f"{text}: memory", r["memory"], "2", r["memory"] >= 2.0))
    return found


def goal_table(document: dict) -> str:
    """Goals, ratio first."""
    rows = [
        [f"{ratio:.3g}", goal, "met" if met else "not met", name]
        for name, ratio, goal, met in goals(document)
    ]
    return table(["ratio", "goal", "", "what"], rows)


def tables(document: dict) -> str:
    """All tables of a document."""
    box = document["machine"]
    versions = [f"CalculiX {document['calculix']['version']}"]
    versions.append(f"Exudyn {next(iter(document['exudyn'].values()))['version']}")
    versions.append(f"ROSS {next(iter(document['ross'].values()))['version']}")
    stored = ", ".join(document["stored_before"]) or "none"
    parts = [
        f"{box['processor']}, one thread of {box['cores']} cores, {box['system']}; "
        f"{', '.join(versions)}. Used again from earlier runs: {stored}.\n",
        "Campbell diagrams\n",
        diagram_table(document),
        calculix_notes(document),
        "Reduced bodies, two rigid interfaces, 20 modes\n",
        reduced_table(document),
    ]
    if "solid" in document:
        parts += [
            "Goals\n",
            goal_table(document),
        ]
    return "\n".join(parts)

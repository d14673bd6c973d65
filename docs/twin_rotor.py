# %% [markdown]
# # The twin rotor from Python
#
# Two coaxial shafts that turn against each other, each with a disk: built, computed, looked at. Run
# it as a program, or cell by cell in an editor that knows `# %%`.

# %%
import numpy as np

from solidwhirl.build import bearing, body, cylinder, scene, unbalance
from solidwhirl.pipeline.run import run_scene

L = 0.4 / 3  # m, a third of the inner shaft
inner = body(
    cylinder("shaft", 0.0, 3 * L, 0.02),
    cylinder("disk", L - 0.015, L + 0.015, 0.15, inner_radius_m=0.02),
    interfaces={"A": 0.0, "disk": L, "C": 2 * L, "B": 3 * L},
)
outer = body(
    cylinder("shaft", 2 * L, 3 * L, 0.035, inner_radius_m=0.03),
    cylinder("disk", 2.6 * L - 0.015, 2.6 * L + 0.015, 0.1, inner_radius_m=0.035),
    interfaces={"C": 2 * L, "D": 3 * L},
    speed_ratio=-1.0,
)
stiff = [bearing("A", "inner.A", stiffness_n_per_m=1e10)]
stiff += [bearing("B", "inner.B", stiffness_n_per_m=1e10)]
stiff += [bearing("C", "inner.C", "outer.C", 1e10), bearing("D", "outer.D", "ground", 1e10)]
twin = scene(
    "twin",
    bodies={"inner": inner, "outer": outer},
    bearings=[*stiff, bearing("kxx", "inner.C", stiffness_n_per_m=[8e6, 0.0])],
    speeds_rpm=np.linspace(0, 20000, 21),
    branches=6,
    model={"accuracy": 5e-3},
    analyses=[
        {
            "kind": "unbalance_response",
            "unbalances": [unbalance("inner.disk", 1e-7)],
            "observe": ["inner.disk"],
            "to_rpm": 20000,
            "count": 401,
        }
    ],
)
results = run_scene(twin)
print(results)

# %% [markdown]
# Results are arrays with names, coordinates and units.

# %%
from solidwhirl.datasets.results import datasets

run = datasets(results)  # or datasets("out/ferraris"), the folder of a run
diagram = run["campbell"].to_dataset()
print(diagram.frequency_hz.dims, diagram.frequency_hz.shape)
print(diagram.frequency_hz.sel(speed_rpm=9000).values.round(2), diagram.frequency_hz.units)
print(diagram.whirl.sel(speed_rpm=9000).values)

response = run["analyses/unbalance_response"].to_dataset()
peak = response.major_m.sel(exciter="inner", place="inner.disk").idxmax("speed_rpm")
print(f"largest orbit of the disk at {peak.item():.0f} rpm")

# %% [markdown]
# A figure of your own in the style of the program's pictures.

# %%
import matplotlib.pyplot as plt

from solidwhirl.rotordyn.plots.frame import WHIRL_STYLES, in_style

critical = run["critical_speeds"].to_dataset()
with in_style():
    figure, axes = plt.subplots(figsize=(7.1, 4.4), layout="constrained")
    axes.plot(diagram.speed_rpm, diagram.frequency_hz.T, color="0.85", zorder=0)
    for whirl, style in WHIRL_STYLES.items():
        some = diagram.frequency_hz.where(diagram.whirl == whirl)
        if some.notnull().any():
            look = {"color": style.color, "marker": style.marker, "markerfacecolor": style.face}
            lines = axes.plot(some.speed_rpm, some.T, linestyle=style.dashes, ms=3.5, **look)
            lines[0].set_label(whirl)
    axes.plot(diagram.speed_rpm, diagram.speed_rpm / 60.0, color="0.4", lw=0.8, label="1 x speed")
    axes.plot(critical.speed_rpm, critical.frequency_hz, "k^", mfc="none", label="critical speeds")
    axes.set(xlabel="speed, rpm", ylabel="frequency, Hz", xlim=(0, 20000), ylim=(0, 700))
    axes.legend()
    figure.savefig("twin_rotor.png", dpi=150)

# %% [markdown]
# The bodies are reduced once. Engines with other bearings are assembled of them in milliseconds.

# %%
from dataclasses import replace

from solidwhirl.rotordyn import assemble, critical_speeds

engine = results.system.system
for stiffness in (8e5, 8e6, 8e7):
    bearings = tuple(
        replace(b, stiffness_n_per_m=np.diag([stiffness, 0.0])) if b.name == "kxx" else b
        for b in engine.bearings
    )
    found = critical_speeds(assemble(engine.rotors, bearings), speed_max_rad_s=2000.0)
    print(f"{stiffness:.0e} N/m:", [f"{c.speed_rad_s * 30 / np.pi:.0f} rpm" for c in found])

# %% [markdown]
# The same bodies on other supports.

# %%
from solidwhirl.reduced_scene import reduce_scene

rotor = reduce_scene(twin)
for stiffness in (2e6, 4e6, 8e6):
    softer = rotor.with_(kxx=[stiffness, 0.0])
    print(stiffness, [round(c.critical.speed_rad_s * 30 / np.pi) for c in softer.critical_speeds()])

damped = rotor.with_(kxx={"stiffness_n_per_m": [8e6, 0.0], "damping_n_s_per_m": [2e3, 0.0]})
print(damped.estimates())  # relative errors of the diagram and the critical speeds
damped.draw_campbell("campbell.svg")

# %% [markdown]
# # From a cutter catalogue to the best speed
#
# Three end mills of a catalogue would fit the holder. Which of them, at which speed and how deep? From catalogue, tap
# test and force coefficients to a cut that keeps the power of the spindle and the tolerance of the wall, and a march in
# time, with teeth that may leave the cut, to see whether it holds.

# %%
import matplotlib.pyplot as plt
import numpy as np

import lobex

# %% [markdown]
# ## What is known
#
# - **Cutters**: of one diameter and one length, as catalogues list end mills for aluminium: two teeth; three; four at
#   uneven pitch. Their angles are usual ones and no maker's. Edges are straight, as brazed ones of diamond are; `HELIX`
#   takes angles in degrees.
# - **Tap test**: two bending modes in each direction at the tip of the tool in its holder. The table is made up, of the
#   size that such tests give for a 16 mm end mill in a fast spindle; it stands for yours. It is taken to hold for all
#   three cutters, which have the same holder and stick-out.
# - **Forces**: aluminium 7075-T6 with cemented carbide, cutting and edge forces of table 5, reference 160, of *Milling
#   Force Model for Aviation Aluminum Alloy: Academic Insight and Perspective Analysis*, Chinese Journal of Mechanical
#   Engineering 34 (2021), doi:10.1186/s10033-021-00536-9. Edge forces have no part in stability, but in power and wall.
# - **Cut**: down-milling half of the diameter, at 0.1 mm of feed per tooth.
# - **Limits**: the spindle turns at 9,000 to 24,000 rpm and gives 8 kW; the wall may be off by 30 µm; 15 % of every
#   limit are kept in reserve. No cut is deeper than the diameter.

# %%
DIAMETER, FEED = 16e-3, 1e-4  # m
HELIX = None, None, None  # degrees
CUTTERS = {
    "two teeth": lobex.Cutter.end_mill(DIAMETER, teeth=2, helix_degrees=HELIX[0]),
    "three teeth": lobex.Cutter.end_mill(DIAMETER, teeth=3, helix_degrees=HELIX[1]),
    "four, 84-96-84-96": lobex.Cutter.end_mill(DIAMETER, pitch_degrees=[84, 96, 84, 96], helix_degrees=HELIX[2]),
}
TAPPED = [  # direction, Hz, damping ratio, N/m
    ("x", 640.0, 0.035, 3.2e7),
    ("x", 1780.0, 0.022, 2.1e7),
    ("y", 675.0, 0.038, 3.4e7),
    ("y", 1850.0, 0.024, 2.2e7),
]
ALUMINIUM = lobex.CuttingForce(600.46e6, 180.96e6, tangential_edge=17.9e3, normal_edge=20.42e3)  # N/m², N/m
CUT = {"force": ALUMINIUM, "radial_immersion": 0.5, "direction": "down", "feed_per_tooth": FEED}
SLOWEST, FASTEST, DEEPEST = 9000, 24000, 16e-3  # rpm, rpm, m
POWER, WALL, MARGIN = 8000.0, 30e-6, 0.15  # W, m, 1

axis, frequency, damping_ratio, stiffness = zip(*TAPPED, strict=True)
modes = lobex.Modes.from_table(frequency, damping_ratio, stiffness=stiffness, direction=axis)
mills = {name: lobex.Milling(modes, cutter, **CUT) for name, cutter in CUTTERS.items()}
print(modes)

# %% [markdown]
# ## Three diagrams in one
#
# More teeth remove more at the same depth and speed, and are stable to less depth. So the depths alone do not tell: the
# lower picture shows what they remove, axial depth × radial depth × feed speed.
#
# The power of a spindle is nearly a limit of the removal rate: at the same feed and immersion every cubic centimetre
# takes the same work, K_t and the share of the edge, whatever cutter takes it.

# %%
SPEEDS, SCAN = 61, 25
RPM = np.linspace(SLOWEST, FASTEST, SPEEDS)
limits = {name: lobex.critical_gain(mill, RPM / 60, (1e-4, DEEPEST), scan=SCAN) for name, mill in mills.items()}

arc = np.pi / 2
work = float(ALUMINIUM.tangential) + float(ALUMINIUM.tangential_edge) * arc / FEED  # J/m³
most = (1 - MARGIN) * POWER / work
print(f"{work / 1e6:.0f} J per cm³: {POWER / 1e3:.0f} kW less {MARGIN:.0%} remove {6e7 * most:.0f} cm³/min at most")

figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.0, 6.6), layout="constrained", sharex=True)
COLOURS = dict(zip(CUTTERS, ("#0b7a75", "#c8500a", "#12436d"), strict=True))
stable, removed = {}, {}
for name, limit in limits.items():
    stable[name] = np.where(limit.status == "none in range", DEEPEST, limit.gain)
    removed[name] = mills[name].removal_rate(RPM / 60, (1 - MARGIN) * stable[name])
    least = int(np.argmin(stable[name]))
    print(f"{name}: stable at any speed up to {1e3 * stable[name][least]:.1f} mm; ", end="")
    print(f"up to {6e7 * removed[name].max():.0f} cm³/min by stability alone")
    upper.plot(RPM, 1e3 * stable[name], color=COLOURS[name], label=name)
    lower.plot(RPM, 6e7 * removed[name], color=COLOURS[name])
lower.axhline(6e7 * most, color="black", linestyle="--", linewidth=1.2, label=f"{POWER / 1e3:.0f} kW less {MARGIN:.0%}")
upper.set_ylim(0, 1.08e3 * DEEPEST)
upper.set_ylabel("critical depth of cut $b$ (mm)")
upper.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize="small")
lower.set_xlim(SLOWEST, FASTEST)
lower.set_ylim(0, None)
lower.set_xlabel("spindle speed (rpm)")
lower.set_ylabel(f"removal rate at {1 - MARGIN:.0%} of it (cm³/min)")
lower.legend(loc="upper left", frameon=False, fontsize="small")
plt.show()

# %% [markdown]
# ## The wall that is left
#
# A stable cut vibrates in step with its teeth, and where a tooth passes the finished wall the tool's place is left in
# it. `orbit` is that motion, and tells the power as well. Of the first cutter that stability lets use the whole
# power this is the wall along the stable depths less the reserve: more teeth have no more power to use.

# %%
chosen = next(name for name in CUTTERS if removed[name].max() > most)
mill = mills[chosen]
motion = lobex.orbit(mill, RPM / 60, (1 - MARGIN) * stable[chosen], phase=[0.0])
left = 1e6 * motion.surface_location_error[:, 0, 0]  # equal straight teeth leave the same
within = (np.abs(left) <= 1e6 * (1 - MARGIN) * WALL) & (motion.mean_power <= (1 - MARGIN) * POWER)
print(f"{chosen}: {within.sum()} of {SPEEDS} speeds keep power and wall at {1 - MARGIN:.0%} of the stable depth")

figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.0, 5.6), layout="constrained", sharex=True)
upper.plot(RPM, left, color=COLOURS[chosen], label=chosen)
upper.axhspan(-1e6 * WALL, 1e6 * WALL, color="#0b7a75", alpha=0.12, linewidth=0, label=f"± {1e6 * WALL:.0f} µm")
upper.set_ylabel("material left at the wall (µm)")
upper.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, fontsize="small")
lower.plot(RPM, motion.mean_power / 1e3, color=COLOURS[chosen], label="mean power of the cut")
lower.axhline(POWER / 1e3, color="black", linestyle="--", linewidth=1.2, label="spindle")
lower.set_xlim(SLOWEST, FASTEST)
lower.set_ylim(0, None)
lower.set_xlabel("spindle speed (rpm)")
lower.set_ylabel("power (kW)")
lower.legend(loc="lower right", frameon=False, fontsize="small")
plt.show()

# %% [markdown]
# ## The recommendation
#
# `recommend` goes down from the stable depth until power and wall are kept too, speed by speed, and takes the cuts of
# highest removal rate. Each says what binds it, and how much of every limit it leaves.

# %%
CUTS = 3
advice = lobex.recommend(
    mill,
    (SLOWEST / 60, FASTEST / 60),
    (1e-3, DEEPEST),
    power=POWER,
    location_error=WALL,
    margin=MARGIN,
    count=CUTS,
)
print(advice)
axes = advice.plot()
axes.plot(RPM, 1e3 * stable[chosen], color="0.6", linewidth=1.0, label="limit of stability")
axes.set_ylim(0, 1.08e3 * DEEPEST)
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize="small")
plt.show()

# %% [markdown]
# ## A march in time, in which teeth may leave the cut
#
# Nothing of lobex but the numbers of the tool and of the cut is in this march: modes as complex oscillators, exact for
# the force of a step, edges in slices, and the surface as an array of angles and heights, on which each tooth leaves
# what it cuts and finds what the ones ahead of it left. With `lost` a tooth that comes out of the material has no force
# and leaves the surface as it is; without, it is pulled back in, which is the linear model.

# %%
STEPS, SLICES, TURNS = 720, 12, 60  # steps a turn


def march(mill, speed, depth, lost):
    """Of several cuts side by side the tip, (turns * steps, cuts, 2), and the chips of all teeth, per step."""
    cutter, omega, ratio = mill.cutter, np.asarray(mill.modes.angular_frequency), np.asarray(mill.modes.damping_ratio)
    pole = omega * (-ratio + 1j * np.sqrt(1 - ratio**2))
    flight = np.exp(pole / (STEPS * speed[:, None]))
    push = (flight - 1) / pole / (2j * pole.imag)
    pitch = np.full(cutter.teeth, 2 * np.pi / cutter.teeth) if cutter.pitch is None else np.asarray(cutter.pitch)
    tips = np.rint(STEPS / (2 * np.pi) * (np.cumsum(pitch) - pitch)).astype(int)
    height = depth[:, None] * (np.arange(SLICES) + 0.5) / SLICES
    lag = height * (0.0 if cutter.twist is None else float(cutter.twist))
    angle = np.mod(2 * np.pi * np.arange(STEPS)[:, None, None] / STEPS - lag, 2 * np.pi)
    entry, leave = mill.engagement
    cuts = (angle >= entry) & (angle < leave)
    normal = np.stack([np.sin(angle), np.cos(angle)])
    along = np.stack([np.cos(angle), -np.sin(angle)])
    width = cuts * (depth[:, None] / SLICES)
    per_chip = -width * (mill.tangential * along + mill.normal * normal)
    per_edge = -width * (mill.edge[0] * along + mill.edge[1] * normal)
    fed = mill.feed_per_tooth * cutter.teeth * pitch[:, None, None] / (2 * np.pi)
    surface, state, before = np.zeros_like(angle), np.zeros((len(speed), len(omega)), complex), 0.0
    shape, lost = np.asarray(mill.modes.shape), np.asarray(lost)[:, None]
    tip, chips = np.zeros((TURNS * STEPS, len(speed), 2)), np.zeros((TURNS * STEPS, len(speed)))
    for i in range(TURNS * STEPS):
        at = (i + tips) % STEPS
        tip[i] = 2 * state.real @ shape
        reach = normal[0, at] * tip[i, :, 0, None] + normal[1, at] * tip[i, :, 1, None]
        found = surface[at] - fed * normal[0, at]
        out = lost & (reach < found)
        surface[at] = np.where(out, found, reach)
        chip = np.where(out, 0.0, reach - found)
        force = np.sum(per_chip[:, at] * chip + per_edge[:, at] * ~out, axis=(1, 3)).T
        chips[i] = np.sum(chip * cuts[at], axis=(0, 2))
        # That of the middle of the step, from this one and the last.
        state = flight * state + push * ((1.5 * force - 0.5 * before) @ shape.T)
        before = force
    return tip, chips


# %% [markdown]
# Two cuts of the recommended depth, each with teeth that may leave the cut and without: at the recommended speed, and
# at the fast speed with the lowest limit. Without, the vibration grows from turn to turn as the multipliers say; with,
# it stays, as a chatter that is heard: the strongest line of the motion that is no harmonic of a turn.

# %%
best_speed, best_depth = float(advice.speed[0]), float(advice.depth[0])
poor = int(np.argmin(np.where(RPM > 0.6 * FASTEST, stable[chosen], np.inf)))
poor_speed = RPM[poor] / 60
speeds, lost = np.array([best_speed, best_speed, poor_speed, poor_speed]), np.array([True, False, True, False])
tip, chips = march(mill, speeds, np.full(4, best_depth), lost)

# The change from turn to turn, in which the periodic motion drops out.
change = np.linalg.norm(np.diff(tip.reshape(TURNS, STEPS, -1, 2), axis=0), axis=(1, 3))
expected = lobex.spectral_radius(mill, speeds[[1, 3]], best_depth) ** mill.cutter.alike
growth = np.ones(2)
for case, lane in enumerate((1, 3)):
    kept = np.flatnonzero(change[:, lane] > 1e-8 * change[0, lane])
    kept = kept[len(kept) // 3 :]
    growth[case] = np.exp(np.polyfit(kept, np.log(change[kept, lane]), 1)[0])
    print(f"{60 * speeds[lane]:.0f} rpm: times {growth[case]:.3f} in a turn without loss of contact, ", end="")
    print(f"{expected[case]:.3f} by the multipliers")

period = STEPS // mill.cutter.alike
path = lobex.orbit(mill, best_speed, best_depth, phase=np.arange(period) / period)
size, apart = np.abs(path.displacement).max(), np.abs(tip[-STEPS:, 0][:period] - path.displacement).max()
print(f"recommended: from the periodic motion, of up to {1e6 * size:.0f} µm, the march ends {1e6 * apart:.1f} µm away")

heard = tip[TURNS // 2 * STEPS :, 2, 1]
spectrum = np.abs(np.fft.rfft((heard - heard.mean()) * np.hanning(len(heard))))
orders = np.arange(len(spectrum)) / (TURNS - TURNS // 2)
harmonic = np.abs(orders - np.rint(orders)) < 2.5 / (TURNS - TURNS // 2)
chatter = float(poor_speed * orders[np.argmax(np.where(harmonic, 0, spectrum))])
scatter, swing = 1e6 * np.ptp(heard[::STEPS]), 1e6 * np.ptp(heard)
print(f"{RPM[poor]:.0f} rpm: chatter at {chatter:.0f} Hz; the tip swings {swing:.0f} µm across the feed, ", end="")
print(f"and once a turn it is somewhere within {scatter:.0f} µm")

# %% [markdown]
# ## The next speed after a cut that chattered
#
# A shop that knows nothing but the sound tries the speeds at which the teeth pass once in a whole number of its waves;
# with a process they are ranked by its limits.

# %%
found = lobex.next_speed(
    chatter, mill.cutter.teeth, speed=(SLOWEST / 60, FASTEST / 60), process=mill, bounds=(1e-4, DEEPEST)
)
print(found)
next_speed = float(found.speed[0])
after, _ = march(mill, np.array([next_speed]), np.array([best_depth]), np.array([True]))
settled = after[TURNS // 2 * STEPS :, 0, 1]
once, swung = 1e6 * np.ptp(settled[::STEPS]), 1e6 * np.ptp(settled)
print(f"{60 * next_speed:.0f} rpm and {1e3 * best_depth:.1f} mm: once a turn the tip is within {once:.2f} µm, ", end="")
print(f"but it swings {swung:.0f} µm")

# %% [markdown]
# ## Conclusion
#
# At the recommended speed and depth the march settles, whether teeth may leave the cut or not, on the motion that the
# orbit told. The same depth at another speed chatters. The speed that its sound asks for is free of chatter, and yet no
# place to finish a wall: there the teeth pass in step with a natural frequency, which is what keeps the chip even and
# what makes the forced motion large. That is why the recommendation keeps away from the highest pocket.

# %%
figure, panels = plt.subplots(3, 1, figsize=(7.0, 6.4), layout="constrained", sharex=True, sharey=True)
turn = np.arange(TURNS * STEPS) / STEPS
for panel, speed, line, colour in (
    (panels[0], best_speed, tip[:, 0, 1], "#12436d"),
    (panels[1], poor_speed, tip[:, 2, 1], "#c8500a"),
    (panels[2], next_speed, after[:, 0, 1], "#0b7a75"),
):
    panel.plot(turn, 1e6 * line, color="0.8", linewidth=0.4)
    panel.plot(turn[::STEPS], 1e6 * line[::STEPS], ".", color=colour, markersize=5, label="once a turn")
    panel.set_title(f"{60 * speed:.0f} rpm, {1e3 * best_depth:.1f} mm", loc="left", fontsize="medium")
    panel.set_ylabel("tip across\nthe feed (µm)")
    panel.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize="small", borderaxespad=0.2)
panels[2].set_xlim(0, TURNS)
panels[2].set_xlabel("turns of the spindle")
plt.show()

"""A joint with LuGre friction in MuJoCo (`dcmotor lugre`, since 3.7), held by a third of breakaway.

    python3 -m venv target/mujoco && target/mujoco/bin/pip install mujoco
    target/mujoco/bin/python benches/mujoco/creep.py [--out benches/mujoco]

Leaves `creep.csv`: for each integrator, stiffness and step the position after 1 s and 2 s [rad], the
largest speed [rad/s], and whether MuJoCo reset the run because a number was bad. A joint that stands
is at F/σ0, and a little beyond it by what the bristle has slipped while it swung in.

And `sine.csv`: the same joint of 1e4 N m/rad under 2 sin(2πt) N m, for each integrator and step the
CPU time [s], the least of seven runs, and the position [rad] every 0.1 s. The example `mujoco` of
bristle-convert draws both beside this library.

The rows `ten lines` do the friction beside MuJoCo, as docs/coming-from.md of bristle-convert says: a
torque and a joint damping, which its integrator takes implicitly.
"""

import argparse
import csv
import math
import time
from pathlib import Path

import mujoco
import numpy
from mujoco import rollout

INERTIA = 0.01  # kg m²
COULOMB, STATIC, STRIBECK = 1.0, 1.5, 0.1  # N m, N m, rad/s
TORQUE = STATIC / 3  # N m
END = 2.0  # s

MODEL = """<mujoco>
  <option timestep="{step}" integrator="{integrator}" gravity="0 0 0"><flag contact="disable"/></option>
  <worldbody><body>
    <joint name="joint" type="hinge" axis="0 0 1" armature="{inertia}"/>
    <geom type="sphere" size="0.001" mass="0.001"/>
  </body></worldbody>
  {actuator}
</mujoco>"""
ACTUATOR = """<actuator>
    <dcmotor joint="joint" motorconst="0" resistance="1" input="none" lugre="{lugre}"/>
  </actuator>"""


def model(integrator, step, actuator):
    text = MODEL.format(step=step, integrator=integrator, inertia=INERTIA, actuator=actuator)
    made = mujoco.MjModel.from_xml_string(text)
    return made, mujoco.MjData(made)


def run(made, data, step, before=lambda: None, after=lambda: None):
    """Position after a half and after the whole, largest speed, and whether it was reset."""
    places, fastest = [], 0.0
    count = round(END / step)
    for n in range(count):
        data.qfrc_applied[0] = TORQUE
        before()
        mujoco.mj_step(made, data)
        after()
        fastest = max(fastest, abs(data.qvel[0]))
        if n + 1 in (count // 2, count):
            places.append(data.qpos[0])
    reset = any(warning.number for warning in data.warning)
    return [*places, fastest, int(reset)]


def theirs(integrator, stiffness, damping, step):
    numbers = (stiffness, damping, COULOMB, STATIC, STRIBECK)
    actuator = ACTUATOR.format(lugre=" ".join(map(str, numbers)))
    return run(*model(integrator, step, actuator), step)


def ten_lines(stiffness, damping, step):
    made, data = model("implicitfast", step, "")
    z, end = 0.0, (0.0, 0.0)

    def before():
        nonlocal end
        speed = abs(data.qvel[0])
        mu = COULOMB + (STATIC - COULOMB) * math.exp(-((speed / STRIBECK) ** 2))
        resistance = damping * speed + mu
        drive, x = mu / resistance, step * stiffness * speed / resistance
        phi1 = -math.expm1(-x) / x if x > 0 else 1.0
        phi2 = (1 - phi1) / x if x > 1e-3 else 0.5 - x / 6
        data.qfrc_applied[0] -= stiffness * drive * phi1 * z
        made.dof_damping[0] = drive * (stiffness * drive * phi2 * step + damping)
        end = (math.exp(-x) * z, phi1 * step * drive)

    def after():
        nonlocal z
        z = end[0] + end[1] * data.qvel[0]

    return run(made, data, step, before, after)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("benches/mujoco"))
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    print(f"MuJoCo {mujoco.__version__}: {TORQUE} N m of {STATIC} N m for {END} s")
    print("stiffness  step [ms]  method          x(2 s) [rad]  x(2 s) - x(1 s)  largest speed  reset")
    with open(out / "creep.csv", "w", newline="") as file:
        table = csv.writer(file)
        head = ["method", "stiffness", "step", "place_1s", "place_2s", "fastest", "reset"]
        table.writerow(head)
        for stiffness in (1e4, 1e5, 1e6):
            damping = math.sqrt(INERTIA * stiffness)
            for step in (5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4):
                for method in ("Euler", "RK4", "implicitfast", "implicit", "ten lines"):
                    if method == "ten lines":
                        found = ten_lines(stiffness, damping, step)
                    else:
                        found = theirs(method, stiffness, damping, step)
                    half, whole, fastest, reset = found
                    table.writerow([method, stiffness, step, *found])
                    print(f"{stiffness:9.0e}  {1e3 * step:9}  {method:14}  {whole:12.4e}"
                          f"  {whole - half:15.2e}  {fastest:13.3e}  {'yes' if reset else ''}")
    with open(out / "sine.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["method", "step", "cpu"] + [f"x{n}" for n in range(1, 21)])
        for step in (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5):
            for method in ("Euler", "RK4", "implicitfast", "implicit"):
                table.writerow([method, step, *sine(method, step)])


def sine(integrator, step):
    """CPU time [s] of a run without Python between its steps, and positions every 0.1 s."""
    numbers = (1e4, math.sqrt(INERTIA * 1e4), COULOMB, STATIC, STRIBECK)
    actuator = ACTUATOR.format(lugre=" ".join(map(str, numbers)))
    made, data = model(integrator, step, actuator)
    count = round(END / step)
    # The torque at the middle of a step: of second order, whatever the integrator does.
    middles = (numpy.arange(count) + 0.5) * step
    torque = 2.0 * numpy.sin(2 * math.pi * middles).reshape(1, count, 1)
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = numpy.empty(mujoco.mj_stateSize(made, spec))
    mujoco.mj_getState(made, data, start, spec)
    least = math.inf
    for _ in range(7):
        before = time.process_time()
        states, _ = rollout.rollout(
            made, data, start, torque, control_spec=mujoco.mjtState.mjSTATE_QFRC_APPLIED
        )
        least = min(least, time.process_time() - before)
    each = round(0.1 / step)
    # The first number of a state is the time, the second the position.
    return [least, *states[0, each - 1 :: each, 1]]


if __name__ == "__main__":
    main()

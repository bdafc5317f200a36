"""A joint with LuGre friction in MuJoCo (`dcmotor lugre`, since 3.7), held by a third of breakaway.

    python3 -m venv target/mujoco && target/mujoco/bin/pip install mujoco
    target/mujoco/bin/python benches/mujoco/creep.py [--out target/figures]

Leaves `creep.csv`: for each integrator, stiffness and step the position after 1 s and 2 s [rad], the
largest speed [rad/s], and whether MuJoCo reset the run because a number was bad. A joint that stands
is at F/σ0, and a little beyond it by what the bristle has slipped while it swung in.

The rows `ten lines` do the friction beside MuJoCo, as docs/coming-from.md of bristle-convert says: a
torque and a joint damping, which its integrator takes implicitly.
"""

import argparse
import csv
import math
from pathlib import Path

import mujoco

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
    parser.add_argument("--out", type=Path, default=Path("target/figures"))
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
            for step in (2e-3, 5e-4, 1e-4):
                for method in ("Euler", "RK4", "implicitfast", "implicit", "ten lines"):
                    if method == "ten lines":
                        found = ten_lines(stiffness, damping, step)
                    else:
                        found = theirs(method, stiffness, damping, step)
                    half, whole, fastest, reset = found
                    table.writerow([method, stiffness, step, *found])
                    print(f"{stiffness:9.0e}  {1e3 * step:9}  {method:14}  {whole:12.4e}"
                          f"  {whole - half:15.2e}  {fastest:13.3e}  {'yes' if reset else ''}")


if __name__ == "__main__":
    main()

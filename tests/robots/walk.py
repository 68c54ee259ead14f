"""Robots of public packages, here and in MuJoCo itself: which are read, which run, and whether they move alike.

Usage: walk.py PROGRAM LIBRARY [--only PACKAGE]... [--details FILE] [--hold EXPECTED | --expect EXPECTED]

Definition: of each URDF, SDF and MJCF file of a package, MuJoCo's own importer is the yardstick. A file that it loads has to run
here, with the same total mass (to 1e-6 of it) and as many degrees of freedom. Both then move for a second from the same
start under gravity, without contact and with idle drives, in steps of 2 ms (or the file's own, if shorter) and by the same
integrator; they move alike if no link's origin is farther off than 0.1 mm and no link is turned by more than 1e-4. Where
they do not, the program must have said beforehand that something of the motion is not carried over, or MuJoCo's own
simulation must have been unstable.

--hold fails if a count, a file that is refused or one that moves otherwise is not as in EXPECTED; --expect writes that file.

MuJoCo gets each file as it is, but for what concerns its importer and not the robot: links that are fixed to each other stay
links, and of a URDF what is only seen is left out, package:// becomes the package's folder, and a mesh in a format that it does not read is left out.
"""

import argparse
import collections
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

SECONDS = 1.0
STEP = 0.002
SHORTEST_STEP = 0.0001
PACKAGES = {
    "robosuite": ["robosuite"],
    "pybullet_data": ["pybullet_data"],
    "dm_control": ["dm_control"],
    "example-robot-data": ["cmeel.prefix/share/example-robot-data"],
    "gymnasium-robotics": ["gymnasium_robotics"],
}
# What a scene sets itself, on both sides here.
OVERRIDDEN = {f"option@{name}" for name in ("timestep", "gravity", "integrator", "cone", "impratio")}
# A thousand things to grasp, all made by one program: one of each fifty.
SAMPLED = re.compile(r"random_urdfs/(\d+)/")


def files_of(site, package):
    found = []
    for folder in PACKAGES[package]:
        for path in sorted((site / folder).rglob("*")):
            if path.suffix not in (".urdf", ".xml", ".sdf"):
                continue
            sampled = SAMPLED.search(str(path))
            if sampled and int(sampled[1]) % 50:
                continue
            if re.search(rb"<(robot|mujoco|sdf)\b", path.read_bytes()[:100000]):
                found.append(path)
    return found


def in_packages(path, named):
    """The file that package:// or model:// names, as the program looks for it."""
    package, _, inside = named.partition("/")
    for folder in path.resolve().parents:
        for candidate in ([folder / inside] if folder.name == package else []) + [folder / named]:
            if candidate.is_file():
                return candidate
    return None


def urdf_spec(path):
    text = path.read_bytes().rstrip(b"\0 \n").decode("utf-8", "replace")
    root = ET.fromstring(text)
    if root.tag != "robot":
        raise ValueError("no robot")
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        for collision in link.findall("collision"):
            mesh = collision.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.get("filename", "")
            scheme, _, rest = name.partition("://")
            found = in_packages(path, rest) if rest and scheme in ("package", "model") else path.parent / (rest or name)
            if found is None or not found.is_file() or found.suffix.lower() not in (".stl", ".obj", ".msh"):
                link.remove(collision)
            else:
                mesh.set("filename", str(found))
    for extension in root.findall("mujoco"):
        root.remove(extension)
    ET.SubElement(ET.SubElement(root, "mujoco"), "compiler", strippath="false", discardvisual="false")
    return mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))


def in_mujoco(path):
    try:
        spec = urdf_spec(path) if path.suffix == ".urdf" else mujoco.MjSpec.from_file(str(path))
        spec.compiler.fusestatic = False
        model = spec.compile()
    except Exception as error:
        return {"unread": str(error).strip().split("\n")[0]}
    option = model.opt
    option.timestep = max(min(STEP, option.timestep), SHORTEST_STEP)
    option.gravity[:] = [0, 0, -9.81]
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    data = mujoco.MjData(model)
    for _ in range(round(SECONDS / option.timestep)):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    name = lambda index: mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, index) or ""
    bodies = [[name(i), data.xpos[i].tolist(), data.xquat[i].tolist()] for i in range(1, model.nbody)]
    sound = all(warning.number == 0 for warning in data.warning)
    return {"mass_kg": float(model.body_mass.sum()), "freedoms": model.nv, "bodies": bodies, "sound": sound}


def apart(ours, theirs):
    """The largest distance and turn between the same links; None if they are not the same."""
    # Geoms of the world belong to a link of their own here.
    ours = [body for index, body in enumerate(ours) if not (index == 0 and body[0] == "world")]
    theirs = [body for index, body in enumerate(theirs) if not (index == 0 and body[0] == "world")]
    names = {body[0]: body for body in ours}
    if all(body[0] in names for body in theirs):
        pairs = [(names[body[0]], body) for body in theirs]
    elif len(ours) == len(theirs):
        pairs = list(zip(ours, theirs))
    else:
        return None
    farthest = turned = 0.0
    for a, b in pairs:
        farthest = max(farthest, float(np.linalg.norm(np.subtract(a[1], b[1]))))
        turned = max(turned, 2 * float(min(np.linalg.norm(np.subtract(a[2], b[2])), np.linalg.norm(np.add(a[2], b[2])))))
    return [farthest, turned]


def compared(ours, theirs):
    row = {"theirs": "unread" not in theirs, "read": "unread" not in ours, "runs": "bodies" in ours}
    if not (row["theirs"] and row["runs"]):
        return row
    row["mass"] = abs(ours["mass_kg"] - theirs["mass_kg"]) <= 1e-6 * max(theirs["mass_kg"], 1e-3)
    row["freedoms"] = ours["freedoms"] == theirs["freedoms"]
    distance = apart(ours["bodies"], theirs["bodies"])
    row["apart"] = distance
    row["motion"] = distance is not None and distance[0] <= 1e-4 and distance[1] <= 1e-4
    row["reasons"] = sorted({element or what for effect, element, what in ours["gaps"] if effect in ("motion", "doubt")} - OVERRIDDEN)
    if not theirs["sound"]:
        row["reasons"].append("MuJoCo's own simulation of it is unstable")
    row["said"] = row["motion"] or bool(row["reasons"])
    return row


def walk(program, library, site, packages):
    results = {}
    for package in packages:
        files = files_of(site, package)
        print(f"{package}: {len(files)} files", file=sys.stderr)
        run = subprocess.run([program, library, str(SECONDS)], input="\n".join(map(str, files)), text=True, capture_output=True)
        lines = [json.loads(line) for line in run.stdout.splitlines()]
        if len(lines) != len(files):
            sys.exit(f"{program} ended early with {files[len(lines)]}: {run.stderr[-2000:]}")
        for path, line in zip(files, lines):
            theirs = in_mujoco(path) if path.suffix != ".sdf" else {"unread": "MuJoCo reads no SDF"}
            row = compared(line["ours"], theirs)
            results[package, str(path.relative_to(site))] = {"row": row, "ours": line["ours"], "theirs": theirs}
    return results


COLUMNS = ["files", "MuJoCo loads", "read", "run", "mass", "freedoms", "motion", "motion said"]


def table(results):
    counts = collections.defaultdict(lambda: [0] * len(COLUMNS))
    for (package, _), result in results.items():
        row = result["row"]
        loads = row["theirs"]
        found = [True, loads, loads and row["read"], loads and row["runs"], row.get("mass"), row.get("freedoms"), row.get("motion"), row.get("said")]
        counts[package] = [old + bool(new) for old, new in zip(counts[package], found)]
    return counts


def found_in(results):
    """What is held: counts, refusals by their reasons, and what moves otherwise, by what is not carried over."""
    refused, otherwise, wrong = {}, {}, []
    for (package, path), result in results.items():
        row, ours = result["row"], result["ours"]
        if not row["theirs"]:
            continue
        if not row["runs"]:
            # Without the place, which is the file's own.
            reason = (ours.get("unread") or ours.get("refused")).split("\n")[0]
            refused[path] = re.sub(r"^.*?:\d+:\d+: ", "", reason)
            continue
        wrong += [f"{path}: another {what}" for what in ("mass", "freedoms") if not row[what]]
        if not row["motion"]:
            otherwise[path] = ", ".join(row["reasons"])
            wrong += [] if row["said"] else [f"{path} moves otherwise by {row['apart']}, and nothing says why"]
    return {"counts": table(results), "refused": refused, "moves_otherwise": otherwise}, wrong


def written(found):
    lines = ["# By package: " + ", ".join(COLUMNS) + ".", "[counts]"]
    lines += [f"{package} = {counts}" for package, counts in found["counts"].items()]
    lines += ["", "# Files that MuJoCo loads and that are refused here, with the reason.", "[refused]"]
    lines += [f"{json.dumps(path)} = {json.dumps(reason)}" for path, reason in sorted(found["refused"].items())]
    lines += ["", "# Files of which something said beforehand is not carried over, so that they move otherwise.", "[moves_otherwise]"]
    lines += [f"{json.dumps(path)} = {json.dumps(reason)}" for path, reason in sorted(found["moves_otherwise"].items())]
    return "\n".join(lines) + "\n"


def differences(found, expected, packages):
    for package in packages:
        if found["counts"][package] != expected["counts"][package]:
            yield f"{package}: {found['counts'][package]}, expected {expected['counts'][package]}"
    for kind in ("refused", "moves_otherwise"):
        now, before = found[kind], expected[kind]
        if len(packages) < len(PACKAGES):
            folders = tuple(folder for package in packages for folder in PACKAGES[package])
            before = {path: reason for path, reason in before.items() if path.startswith(folders)}
        for path in sorted(now.keys() | before.keys()):
            if now.get(path) != before.get(path):
                yield f"{path}, {kind}: {now.get(path, 'no longer')}, expected {before.get(path, 'not')}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("library")
    parser.add_argument("--only", action="append")
    parser.add_argument("--details", type=pathlib.Path)
    parser.add_argument("--hold", type=pathlib.Path)
    parser.add_argument("--expect", type=pathlib.Path)
    arguments = parser.parse_args()
    for name in ("program", "library", "details", "hold", "expect"):
        if getattr(arguments, name):
            setattr(arguments, name, os.path.abspath(getattr(arguments, name)))
    # MuJoCo writes its warnings to a file in the folder where it runs.
    os.chdir(tempfile.mkdtemp())
    site = pathlib.Path(mujoco.__file__).parent.parent
    packages = arguments.only or list(PACKAGES)
    results = walk(arguments.program, arguments.library, site, packages)
    print("package | " + " | ".join(COLUMNS))
    for package, counts in table(results).items():
        print(f"{package} | " + " | ".join(map(str, counts)))
    if arguments.details:
        with open(arguments.details, "w") as file:
            for (package, path), result in results.items():
                file.write(json.dumps({"package": package, "path": path, **result}) + "\n")
    found, wrong = found_in(results)
    if arguments.expect:
        pathlib.Path(arguments.expect).write_text(written(found))
    if arguments.hold:
        with open(arguments.hold, "rb") as file:
            wrong += differences(found, tomllib.load(file), packages)
    for line in wrong:
        print(line)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()

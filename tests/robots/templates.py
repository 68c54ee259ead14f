"""xacro files of public packages, expanded here and by the Python program: whether they become the same XML.

Usage: templates.py EXPAND FOLDER... [--arguments FILE:NAME=VALUE,...]...

EXPAND is the example `expand_xacro`. Each `.xacro` file below the folders that the Python program expands has to become the
same tree of elements, attributes and texts here; paths of packages are addresses here (`package://NAME/...`). What the Python program
refuses is passed over and counted. Fails if one differs or is refused here alone.
"""

import argparse
import collections
import os
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET

import xacro as oracle

# What stands for the index of installed packages: a folder with one link for each.
SHIM = """import os
def get_package_share_directory(name):
    folder = os.path.join(os.environ["PACKAGES"], name)
    if not os.path.exists(folder):
        raise KeyError(name)
    return folder
"""


def packages_of(folders, into):
    """Links the packages below folders by the names that they give themselves."""
    for folder in folders:
        for file in sorted(folder.rglob("package.xml")):
            try:
                name = ET.parse(file).getroot().findtext("name", "").strip()
            except ET.ParseError:
                continue
            if name and not (into / name).exists():
                os.symlink(file.parent.resolve(), into / name)


def tree(element, packages):
    """An element without what does not count: blanks, and the order of attributes and of texts between elements."""

    def plain(text):
        text = text.replace(f"file://{packages}/", "package://").replace(f"{packages}/", "package://")
        return " ".join(text.split())

    texts = [element.text or ""] + [child.tail or "" for child in element]
    children = (child for child in element if isinstance(child.tag, str))
    attributes = tuple(sorted((name, plain(value)) for name, value in element.attrib.items()))
    return (element.tag, attributes, plain(" ".join(texts)), tuple(tree(child, packages) for child in children))


def difference(one, other, path=""):
    """Where two trees differ first."""
    path = f"{path}/{one[0]}"
    for what, a, b in zip(("element", "attributes", "text"), one, other):
        if a != b:
            return f"{path}: {what} {a} and {b}"
    for a, b in zip(one[3], other[3]):
        found = difference(a, b, path)
        if found:
            return found
    return f"{path}: {len(one[3])} and {len(other[3])} children" if one[3] != other[3] else None


def expanded(expand, file, arguments, packages, environment):
    """What becomes of a file: a word, and what there is to say."""
    given = [f"{name}:={value}" for name, value in arguments]
    program = [sys.executable, "-c", "import xacro; xacro.main()", str(file), *given]
    theirs = subprocess.run(program, env=environment, capture_output=True, text=True, timeout=120)
    pairs = [f"{name}={value}" for name, value in arguments]
    command = [expand, str(file), str(packages), *pairs]
    ours = subprocess.run(command, capture_output=True, text=True, timeout=120)
    if theirs.returncode:
        return ("refused by both", "") if ours.returncode else ("refused by the Python program", "")
    if ours.returncode:
        return "refused here", ours.stderr.strip()
    found = difference(*(tree(ET.fromstring(text), packages) for text in (theirs.stdout, ours.stdout)))
    return ("differ", found) if found else ("equal", "")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("expand")
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--arguments", action="append", default=[])
    options = parser.parse_args()
    counts = collections.Counter()
    with tempfile.TemporaryDirectory() as temporary:
        packages = pathlib.Path(temporary).resolve() / "packages"
        shim = packages.parent / "ament_index_python"
        packages.mkdir()
        shim.mkdir()
        (shim / "__init__.py").touch()
        (shim / "packages.py").write_text(SHIM)
        packages_of(options.folders, packages)
        environment = os.environ | {"PACKAGES": str(packages), "PYTHONPATH": str(packages.parent)}
        files = [(file, []) for folder in options.folders for file in sorted(folder.rglob("*.xacro"))]
        for text in options.arguments:
            file, _, pairs = text.partition(":")
            files.append((pathlib.Path(file), [tuple(pair.split("=", 1)) for pair in pairs.split(",")]))
        for file, arguments in files:
            word, said = expanded(options.expand, file, arguments, packages, environment)
            counts[word] += 1
            if word in ("differ", "refused here"):
                print(f"{word}: {file}\n    {said}")
    print(f"{dict(sorted(counts.items()))}, by {oracle.__name__}")
    return 1 if counts["differ"] or counts["refused here"] or not counts["equal"] else 0


if __name__ == "__main__":
    sys.exit(main())

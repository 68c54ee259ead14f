"""Reads, with the tools whose formats they have, the files that the test other_tools writes.

    python3 crates/requirement-files/tests/peers/read.py FOLDER

Needs the packages reqif, strictdoc and doorstop; what is not installed is skipped with a line. Exits with 1 if a file is not
read as it was meant.
"""

import csv
import importlib.util
import pathlib
import subprocess
import sys

TEXTS = {"REQ001": 'The arm shall stop.\n\nAt <once> & "now".', "REQ002": "It's slow: # near"}
failed = []


def check(tool, what, found, expected):
    if found == expected:
        print(f"{tool}: {what} as written")
    else:
        failed.append(f"{tool}: {what}: {found!r} instead of {expected!r}")


def with_reqif(path):
    from reqif.parser import ReqIFParser, ReqIFZParser

    if path.suffix == ".reqifz":
        bundle = next(iter(ReqIFZParser.parse(str(path)).reqif_bundles.values()))
    else:
        bundle = ReqIFParser.parse(str(path))
    names = {}
    for kind in bundle.core_content.req_if_content.spec_types:
        for definition in getattr(kind, "attribute_definitions", None) or []:
            names[definition.identifier] = definition.long_name
    ids, count = {}, 0
    for thing in bundle.core_content.req_if_content.spec_objects:
        values = {names[value.definition_ref]: value.value for value in thing.attributes}
        ids[thing.identifier] = values["ReqIF.ForeignID"]
        count += "<xhtml:div" in values["ReqIF.Text"]
    check("reqif", f"{path.name}: ids", sorted(ids.values()), sorted(TEXTS))
    check("reqif", f"{path.name}: texts", count, len(TEXTS))
    relations = bundle.core_content.req_if_content.spec_relations
    check("reqif", f"{path.name}: relations", [(ids[it.source], ids[it.target]) for it in relations], [("REQ002", "REQ001")])
    if path.suffix == ".reqif":
        ran = subprocess.run(
            [sys.executable, "-m", "reqif.cli.main", "validate", "--use-reqif-schema", str(path)], capture_output=True, text=True
        )
        check("reqif", f"{path.name}: schema", "0 errors, 0 schema issues found, 0 semantic issues" in ran.stdout, True)


def with_strictdoc(path):
    out = path.parent / "out"
    command = [sys.executable, "-m", "strictdoc.cli.main", "export", str(path), "--formats=sdoc", "--output-dir", str(out)]
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode:
        failed.append(f"strictdoc: {ran.stdout}{ran.stderr}")
        return
    written = next(out.rglob("*.sdoc")).read_text()
    check("strictdoc", "text after its own export", written.strip(), path.read_text().strip())


def with_doorstop(path):
    import doorstop

    subprocess.run(["git", "init", "-q", str(path.parent)], check=True)
    tree = doorstop.build(cwd=str(path.parent), root=str(path.parent))
    document = tree.find_document("REQ")
    found = {str(item.uid): str(item.text) for item in document.items}
    check("doorstop", "texts", found, TEXTS)
    check("doorstop", "links", [str(link) for link in document.find_item("REQ002").links], ["REQ001"])


def main(folder):
    folder = pathlib.Path(folder)
    rows = list(csv.DictReader(open(folder / "d.csv", newline="")))
    check("csv", "texts", {row["id"]: row["text"] for row in rows}, TEXTS)
    readers = [
        ("reqif", with_reqif, "a.reqif"),
        ("reqif", with_reqif, "b.reqifz"),
        ("strictdoc", with_strictdoc, "c.sdoc"),
        ("doorstop", with_doorstop, "doorstop"),
    ]
    for package, reader, name in readers:
        if importlib.util.find_spec(package) is None:
            print(f"{package}: not installed, skipped")
        else:
            reader(folder / name)
    print("\n".join(failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))

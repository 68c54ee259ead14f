"""Assurance cases in SACM, held against the metamodel by pyecore: types, features, references and how many there have to be.

Usage: sacm.py METAMODEL FILE...

METAMODEL is a folder with the metamodel's five packages (base, terminology, artifact, argumentation, assurancecase) as
`NAME.ecore`, as `tools/sacm` fetches them. It is not part of ours.
"""

import sys
from collections import Counter
from pathlib import Path

from pyecore.resources import URI, ResourceSet

PACKAGES = ["base", "terminology", "artifact", "argumentation", "assurancecase"]


def lacking(element):
    """Names of features of which an element has fewer values than it has to have."""
    for feature in element.eClass.eAllStructuralFeatures():
        value = element.eGet(feature)
        count = len(value) if feature.many else int(value is not None)
        if count < feature.lowerBound:
            yield f"{element.eClass.name}.{feature.name}"


def main():
    resources = ResourceSet()
    for name in PACKAGES:
        package = resources.get_resource(URI(str(Path(sys.argv[1]) / f"{name}.ecore"))).contents[0]
        resources.metamodel_registry[package.nsURI] = package
    for name in sys.argv[2:]:
        # A type, feature or reference that is not there is an error of reading.
        root = resources.get_resource(URI(name)).contents[0]
        elements = [root, *root.eAllContents()]
        faults = [fault for element in elements for fault in lacking(element)]
        assert not faults, f"{name}: {faults}"
        kinds = Counter(element.eClass.name for element in elements)
        print(f"{name}: {', '.join(f'{kind} {count}' for kind, count in sorted(kinds.items()))}")


main()

"""A list of what software is made of. Ref: The Linux Foundation, "SPDX Specification" 2.3 (also
ISO/IEC 5962), in its JSON form."""

import hashlib
import json
import re

# How THIRD_PARTY.md writes licences that are no expressions of SPDX.
EXPRESSIONS = {
    "GPL-3.0 with the runtime library exception": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "Apache-2.0 or BSD-2-Clause": "Apache-2.0 OR BSD-2-Clause",
    "FTL or GPL-2.0-or-later": "FTL OR GPL-2.0-or-later",
}
# Licences that stand alone in THIRD_PARTY.md, and in what npm says of packages.
IDENTIFIERS = {
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "LGPL-2.1-or-later",
    "MIT",
    "MPL-2.0",
    "PSF-2.0",
    "WTFPL",
    "Zlib",
    "curl",
    "libpng-2.0",
}


def licence_expression(text):
    """@return None where the words are no expression"""
    if text in EXPRESSIONS:
        return EXPRESSIONS[text]
    words = re.split(r" AND | OR ", text.strip("()"))
    return text if all(word in IDENTIFIERS for word in words) else None


def sha256(data):
    return {"algorithm": "SHA256", "checksumValue": hashlib.sha256(data).hexdigest()}


class Document:
    """Packages, and how they belong together. One that is added again is there once."""

    def __init__(self, name, created):
        self._name = name
        self._created = created
        self._packages = {}
        self._relations = set()

    def add(self, name, version="", *, licence="", purl="", file=None, comment=""):
        """@param file its bytes @return what relations name it by"""
        fields = {
            "name": name,
            "downloadLocation": "NOASSERTION",
            "filesAnalyzed": False,
            "copyrightText": "NOASSERTION",
            "licenseConcluded": "NOASSERTION",
            "licenseDeclared": licence_expression(licence) or "NOASSERTION",
        }
        if licence and fields["licenseDeclared"] == "NOASSERTION":
            fields["licenseComments"] = licence
        if version:
            fields["versionInfo"] = version
        if comment:
            fields["comment"] = comment
        if purl:
            fields["externalRefs"] = [
                {
                    "referenceCategory": "PACKAGE-MANAGER",
                    "referenceType": "purl",
                    "referenceLocator": purl,
                }
            ]
        if file is not None:
            fields["packageFileName"] = name
            fields["checksums"] = [sha256(file)]
        key = "SPDXRef-" + re.sub(r"[^A-Za-z0-9.]+", "-", f"{name}-{version}").strip("-")
        while self._packages.get(key, fields) != fields:
            key += "."
        self._packages[key] = fields
        return key

    def relate(self, one, relation, other):
        self._relations.add((one, relation, other))

    def describe(self, key):
        self.relate("SPDXRef-DOCUMENT", "DESCRIBES", key)

    def text(self):
        packages = [{"SPDXID": key, **self._packages[key]} for key in sorted(self._packages)]
        relations = [
            {"spdxElementId": one, "relationshipType": relation, "relatedSpdxElement": other}
            for one, relation, other in sorted(self._relations)
        ]
        content = hashlib.sha256(json.dumps([packages, relations]).encode()).hexdigest()
        document = {
            "spdxVersion": "SPDX-2.3",
            "dataLicense": "CC0-1.0",
            "SPDXID": "SPDXRef-DOCUMENT",
            "name": self._name,
            # Only a name: it has to differ where the content does.
            "documentNamespace": f"https://spdx.org/spdxdocs/{self._name}-{content}",
            "creationInfo": {"created": self._created, "creators": ["Tool: terravox-release"]},
            "packages": packages,
            "relationships": relations,
        }
        return json.dumps(document, indent=2, ensure_ascii=False) + "\n"

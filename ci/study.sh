#!/bin/sh
# Runs a study as a step of continuous integration, compares its result with an earlier one, and says by its exit code whether the
# change may go on.
#
# Usage: study.sh STUDY OUT [BASELINE]
#   STUDY      the study's folder
#   OUT        the folder of results; OUT/ci gets junit.xml, summary.md, findings.sarif and, with a baseline, diff.md
#   BASELINE   an earlier folder of results; one that is not there is left out, as in the first run
#
# Environment:
#   CORROBORATE          the program (default: corroborate)
#   CORROBORATE_FAIL_ON  what fails: `regression` (default): a verdict that got worse, or a rate that did beyond chance and beyond the margin,
#                        against the baseline, and without one a violated requirement; `violation`: also a requirement that was violated before;
#                        `undecided`: also one that is not decided; `never`: mistakes of the study alone
#   CORROBORATE_TRUST    folders, separated by colons, whose studies may run the programs that they name; a study that names none needs none
#
# Exits 0 if the change may go on, 1 if not, and as the program where that ends with a mistake (2), a lost result or an interruption.
set -u

if [ $# -lt 2 ]; then
  echo "usage: study.sh STUDY OUT [BASELINE]" >&2
  exit 2
fi
study=$1 out=$2 baseline=${3:-}
program=${CORROBORATE:-corroborate}
fail_on=${CORROBORATE_FAIL_ON:-regression}
case $fail_on in
regression | violation | undecided | never) ;;
*)
  echo "CORROBORATE_FAIL_ON is regression, violation, undecided or never (got $fail_on)" >&2
  exit 2
  ;;
esac

mkdir -p "$out/ci" || exit 2
rm -f "$out/ci/diff.md" "$out/ci/summary.md" "$out/ci/junit.xml" "$out/ci/findings.sarif"
"$program" run "$study" --out "$out" --junit "$out/ci/junit.xml" --markdown "$out/ci/summary.md" \
  --sarif "$out/ci/findings.sarif"
ran=$?
case $ran in
0 | 1 | 3) ;;
*) exit "$ran" ;;
esac
# Work may be done and its result lost.
[ -f "$out/study.json" ] || exit "$ran"

differs=0
has_baseline=false
if [ -n "$baseline" ] && [ -f "$baseline/study.json" ]; then
  has_baseline=true
  "$program" diff "$baseline" "$out" --format markdown >"$out/ci/diff.md"
  differs=$?
  case $differs in
  0 | 1) ;;
  *) exit "$differs" ;;
  esac
  cat "$out/ci/diff.md"
fi

case $fail_on in
never) exit 0 ;;
regression) [ "$has_baseline" = true ] && exit "$differs" ;;
esac
[ "$differs" = 0 ] || exit 1
case $ran in
1) exit 1 ;;
3) [ "$fail_on" != undecided ] || exit 1 ;;
esac
exit 0

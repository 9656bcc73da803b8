#!/usr/bin/env bash
# scripts/check_layers accepts the tree, and says what is wrong with one that breaks each rule:
# check_layers_test.sh SOURCE_DIR
set -euo pipefail
check="$1/scripts/check_layers"
"$check" "$1"

tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
write() {
  mkdir -p "$(dirname "$tree/$1")"
  printf '%s\n' "${@:2}" >"$tree/$1"
}
write framework/estimate/low.h '#pragma once' '#include "framework/module/high.h"'
write framework/graph/plan.cpp '#include <vector>' '#include "framework/estimate/low.h"' \
  '  #  include "sensors/sonar/sonar.h"'
write framework/semantics/predict.cpp '#include <framework/runtime/run.h>'
write framework/study/fine.cpp '#include "framework/semantics/predict.h"'
write framework/odd/new.cpp '#include <vector>'
write sensors/sonar/sonar.h '#include "framework/graph/plan.h"' '#include "sensors/scene/scene.h"'
write sensors/camera/opencv_reader.cpp '#include <opencv2/core.hpp>'
write sensors/camera/camera.cpp '#include <opencv2/core.hpp>' '#include "camera.h"'
write src/main.cpp '#include "sensors/sonar/sonar.h"' '#include "framework/study/study.h"'
write sensors/wall/wall.cpp '// #include "src/main.h"' '#include "src/session.h"'

expected='framework/estimate/low.h:2: includes framework/module/high.h: framework/estimate may include only itself
framework/graph/plan.cpp:3: includes sensors/sonar/sonar.h: framework/graph may include only itself, framework/estimate, framework/module, framework/record
framework/odd/new.cpp:1: framework/odd is no layer: those are estimate, module, record, graph, semantics, runtime, report, study
framework/semantics/predict.cpp:1: includes framework/runtime/run.h: framework/semantics may include only itself, framework/estimate, framework/module, framework/record, framework/graph
sensors/camera/camera.cpp:1: includes opencv2/core.hpp: only sensors/camera/opencv_* may use OpenCV
sensors/camera/camera.cpp:2: includes "camera.h": write the path from the root of the tree
sensors/sonar/sonar.h:1: includes framework/graph/plan.h: sensors may include only itself, framework/estimate, framework/module, framework/record
sensors/wall/wall.cpp:2: includes src/session.h: sensors may include only itself, framework/estimate, framework/module, framework/record'
status=0
actual=$("$check" "$tree") || status=$?
if [[ $status != 1 || $actual != "$expected" ]]; then
  echo "check_layers on a broken tree: status $status, expected 1; output against what was expected:"
  diff <(echo "$actual") <(echo "$expected") || true
  exit 1
fi

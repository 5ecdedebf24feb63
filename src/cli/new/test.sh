#!/bin/sh
# Checks the domain, plans, and has the plan judged by the validator.
set -eu
cd "$(dirname "$0")"
sgap=${SGAP:-sgap}
"$sgap" check {{name}}.hatp {{name}}.toml
"$sgap" plan {{name}}.hatp {{name}}.toml --json -o plan.json
"$sgap" validate {{name}}.hatp {{name}}.toml plan.json

#!/bin/sh
# Runs a test program on several ranks, but every second of its tests, from the first (0) or the second (1) on, and none
# of what each cell does by itself; all with PLIANT_LONG_TESTS.
#
#   tests/half.sh 0|1 COMMAND ...
half=$1
shift
if [ -z "$PLIANT_LONG_TESTS" ]; then
  export GTEST_TOTAL_SHARDS=2 GTEST_SHARD_INDEX="$half"
  export GTEST_FILTER='-*Elastic.*Digits*:*Elastic.*ProjectedHessian*:*Elastic.*Survive*:*Elastic.*AreTheLaws*:*Elastic.*CostNothing*:*Elastic.*WorkAlongAPath*:*Viscous.*ProjectedHessian*:*Viscous.*CostNothing*:*ViscousDigits.*:*MeanDilatation.*Digits*:*Mixed.*AreTheLaws*:*Mullins.*Semidefinite*:*Mullins.*Digits*'
fi
exec "$@"

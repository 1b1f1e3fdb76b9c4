#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Says how a job is, as Snakemake asks: running, success or failed. Needs no accounting database.
if ! said=$(scontrol --oneliner show job "$1" 2>&1); then
  # Long gone, or a controller that does not answer just now.
  case $said in *"Invalid job id"*) echo failed ;; *) echo running ;; esac
  exit
fi
[[ $said =~ JobState=([A-Z_]+) ]]
case ${BASH_REMATCH[1]} in
  COMPLETED) echo success ;;
  BOOT_FAIL | CANCELLED | DEADLINE | FAILED | OUT_OF_MEMORY | PREEMPTED | TIMEOUT) echo failed ;;
  NODE_FAIL) [[ $said == *"Requeue=1"* ]] && echo running || echo failed ;;
  *) echo running ;;
esac

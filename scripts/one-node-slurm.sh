#!/bin/bash
# A Slurm of one node from Debian's packages, for trying array jobs on one machine. As root:
#   apt-get install slurm-wlm munge
#   scripts/one-node-slurm.sh start [FOLDER]     starts munged, slurmctld and slurmd with a configuration of their own
#   scripts/one-node-slurm.sh sweep SWEEP.toml OUT SHARDS [FOLDER]
#                                                runs a sweep as an array job, waits, merges, and compares with a run in one piece
#   scripts/one-node-slurm.sh stop [FOLDER]
# FOLDER (default /tmp/one-node-slurm) keeps configuration, state, logs and process ids. Not for a machine that others use.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
verb=${1:?usage: one-node-slurm.sh start|sweep|stop …}
shift

start() {
    local folder=${1:-/tmp/one-node-slurm}
    mkdir -p "$folder/state" "$folder/spool" "$folder/munge"
    chmod 755 "$folder"
    local cores memory
    cores=$(nproc)
    memory=$(awk '/MemTotal/ { print int($2 / 1024 * 0.8) }' /proc/meminfo)
    cat > "$folder/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
NodeName=$(hostname) NodeAddr=127.0.0.1 CPUs=$cores RealMemory=$memory State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
    # munged wants a key that only its user reads, and a folder that all may enter.
    dd if=/dev/urandom of="$folder/munge/key" bs=1 count=1024 status=none
    chmod 400 "$folder/munge/key"
    munged --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" --pid-file="$folder/munge/pid" \
        --log-file="$folder/munge/log" --seed-file="$folder/munge/seed"
    export SLURM_CONF="$folder/slurm.conf"
    slurmctld -f "$SLURM_CONF"
    slurmd -f "$SLURM_CONF"
    for _ in $(seq 60); do
        if [ "$(sinfo -h -o %T 2>/dev/null)" = idle ]; then
            sinfo
            return
        fi
        sleep 1
    done
    echo "the node did not come up: see $folder/slurmctld.log and slurmd.log" >&2
    exit 1
}

sweep() {
    local file=${1:?} out=${2:?} shards=${3:?} folder=${4:-/tmp/one-node-slurm}
    export SLURM_CONF="$folder/slurm.conf"
    local isolux=${ISOLUX:-isolux}
    ISOLUX=$isolux sbatch --wait --export=ALL --array="1-$shards" --cpus-per-task=1 --output="$out-%A_%a.log" "$here/sweep.sbatch" "$file" "$out"
    "$isolux" merge "$out".shard* --out "$out"
    "$isolux" sweep "$file" --out "$out.whole"
    diff -r "$out" "$out.whole" && echo "the merged array job and one run have the same bytes"
}

stop() {
    local folder=${1:-/tmp/one-node-slurm}
    for pid in slurmd.pid slurmctld.pid munge/pid; do
        if [ -f "$folder/$pid" ]; then kill "$(cat "$folder/$pid")" || true; fi
    done
}

case $verb in
    start | sweep | stop) "$verb" "$@" ;;
    *) echo "usage: one-node-slurm.sh start|sweep|stop …" >&2; exit 2 ;;
esac

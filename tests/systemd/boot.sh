#!/usr/bin/env bash
# Boots a real systemd on a throw-away copy of this machine: boot.sh NAME SCRATCH SOURCE VENV
#
# The root directory is a tmpfs overlay of the host's, made in a mount namespace of its own: when the last process here ends, however it
# ends, the kernel takes the mounts away. The checkout and its environment appear read-only as /srv/longreach and /srv/venv.
# SCRATCH/pid gets the process number of systemd-nspawn.
set -euo pipefail
if [ "${IN_NAMESPACE:-}" != yes ]; then
  IN_NAMESPACE=yes exec unshare --mount --propagation private -- "$0" "$@"
fi
name=$1 scratch=$2 source=$3 venv=$4

hierarchies() {
  if [ -e /sys/fs/cgroup/cgroup.procs ]; then echo /sys/fs/cgroup; else echo /sys/fs/cgroup/systemd; [ ! -d /sys/fs/cgroup/unified ] || echo /sys/fs/cgroup/unified; fi
}

end() {
  [ -z "${nspawn:-}" ] || { kill "$nspawn" 2>/dev/null || true; wait "$nspawn" || true; }
  for hierarchy in $(hierarchies); do
    [ ! -d "$hierarchy/$name" ] || find "$hierarchy/$name" -depth -type d -exec rmdir {} + 2>/dev/null || true
  done
}

mkdir -p "$scratch/tmpfs" "$scratch/root"
mount -t tmpfs -o size=3g tmpfs "$scratch/tmpfs"
mkdir "$scratch/tmpfs/upper" "$scratch/tmpfs/work"
mount -t overlay overlay -o "lowerdir=/,upperdir=$scratch/tmpfs/upper,workdir=$scratch/tmpfs/work" "$scratch/root"
tr -d - </proc/sys/kernel/random/uuid >"$scratch/root/etc/machine-id"

trap end EXIT
trap 'exit 143' TERM INT
for hierarchy in $(hierarchies); do mkdir -p "$hierarchy/$name"; done
# In control groups of its own, or nspawn would leave groups at the top level. All capabilities, or memory could not be locked.
(
  for hierarchy in $(hierarchies); do echo "$BASHPID" >"$hierarchy/$name/cgroup.procs"; done
  exec systemd-nspawn --directory "$scratch/root" --boot --console=pipe --machine "$name" --register=no --keep-unit \
    --capability=all --private-network --bind-ro="$source:/srv/longreach" --bind-ro="$venv:/srv/venv" \
    systemd.unit=basic.target </dev/null
) &
nspawn=$!
echo "$nspawn" >"$scratch/pid.new" && mv "$scratch/pid.new" "$scratch/pid"
wait "$nspawn"

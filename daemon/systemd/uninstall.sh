#!/usr/bin/env bash
# Removes what install.sh put there. Rig file, CAN network files, logs and the user (who owns the logs) stay.
set -euo pipefail
here=$(dirname "$(realpath "$0")")
source "$here/common.sh"

while [ $# -gt 0 ]; do
  case $1 in
    --destdir) destdir=$(staging "$2") ;;
    --prefix) prefix=${2%/} ;;
    *) echo "usage: uninstall.sh [--destdir DIR] [--prefix /opt/longreach]" >&2; exit 2 ;;
  esac
  shift 2
done

check_root "uninstalling removes $prefix and files in /etc" "$(with_root uninstall)"
check_prefix
check_stopped
if [ -z "$destdir" ] && systemd_runs; then systemctl --quiet disable longreachd longreach-reports 2>/dev/null || true; fi
for file in "$unit" "$reports" "$sysusers" "$tmpfiles" "$udev"; do
  if [ -e "$destdir$file" ]; then rm "$destdir$file" && echo "  removed $destdir$file"; fi
done
if [ "$(readlink "$destdir$command" || true)" = "$prefix/bin/longreach" ]; then
  rm "$destdir$command" && echo "  removed $destdir$command"
fi
if [ -e "$destdir$prefix" ]; then rm -rf "$destdir$prefix" && echo "  removed $destdir$prefix"; fi
if [ -z "$destdir" ]; then
  rm -rf /var/cache/longreach # compiled kernels, of no use to anybody else
  if systemd_runs; then systemctl daemon-reload; fi
fi
echo "Kept: /etc/longreach, $network, $link, /var/log/longreach and the user longreach, who owns the logs."

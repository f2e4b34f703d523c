# Shared by install.sh and uninstall.sh: where things go, and what stands in the way.

destdir="" prefix=/opt/longreach python=/usr/bin/python3 from_venv=""
unit=/etc/systemd/system/longreachd.service
reports=/etc/systemd/system/longreach-reports.service
sysusers=/etc/sysusers.d/longreach.conf
tmpfiles=/etc/tmpfiles.d/longreach.conf
udev=/etc/udev/rules.d/70-longreach.rules
network=/etc/systemd/network/10-can0.network
link=/etc/systemd/network/10-can0.link
rig=/etc/longreach/rig.yaml
command=/usr/local/bin/longreach
checkout=$(cd "$here/../.." && pwd)
[ -f "$checkout/pyproject.toml" ] || checkout="" # then it is an installed wheel

refuse() {
  echo "longreach: $1 $2" >&2
  exit 1
}

# Absolute, without a slash at the end; empty for the machine itself.
staging() {
  [ -z "$1" ] || realpath --canonicalize-missing -- "$1" | sed 's|^/$||'
}

systemd_runs() { [ -d /run/systemd/system ]; }

# What to type instead; sudo does not look into a virtual environment.
with_root() {
  if [ -n "$checkout" ]; then
    echo "Run \`sudo make $1\`, or without root below a directory: make $1 DESTDIR=DIR."
  else
    local own=${from_venv:+$from_venv/bin/}longreach
    echo "Run \`sudo $own service $1\`, or without root below a directory: $own service $1 --destdir DIR."
  fi
}

check_root() {
  [ -n "$destdir" ] || [ "$(id -u)" = 0 ] || refuse "$1; you are $(id -un), not root." "$2"
}

# The directory is replaced and removed as a whole, so it must be ours.
check_prefix() {
  case $prefix in /*/*) ;; *) refuse "the prefix $prefix is not a directory of its own." "Give an absolute path such as /opt/longreach." ;; esac
  case $prefix in *[[:space:]\|]*) refuse "the prefix '$prefix' has a space or a bar in it." "Give another." ;; esac
  case $prefix/ in
    /home/* | /root/* | /run/user/*) refuse "the prefix $prefix is in a home directory, which the service cannot see." "Give another." ;;
  esac
  local here=$destdir$prefix
  [ ! -e "$here" ] || [ -e "$here/bin/longreachd" ] || refuse "$here exists and is no longreach." "Give another --prefix, or move it away."
}

# Their child processes are started from the installed files; they must not change under them.
check_stopped() {
  [ -z "$destdir" ] && systemd_runs || return 0
  ! systemctl --quiet is-active longreachd ||
    refuse "longreachd is running." "Stop it first, when the arm may stop: systemctl stop longreachd"
  ! systemctl --quiet is-active longreach-reports ||
    refuse "longreach-reports is running." "Stop it first: systemctl stop longreach-reports"
}

#!/usr/bin/env bash
# Installs longreach as a system service, or stages it for a package with --destdir. Safe to repeat: configuration that is there is
# kept, and the installed environment is replaced only when the new one is complete. Exit status: 0 done, 1 refused, 2 wrong usage.
set -euo pipefail
umask 022
unset PYTHONPYCACHEPREFIX PYTHONDONTWRITEBYTECODE # compiled modules belong into the installed environment, and nowhere else
here=$(dirname "$(realpath "$0")")
source "$here/common.sh"

usage() {
  cat <<'TEXT'
usage: install.sh [--destdir DIR] [--prefix /opt/longreach] [--python /usr/bin/python3] [--from-venv DIR]
  --destdir DIR    stage everything below DIR; nothing outside it is touched, and root is not needed
  --prefix DIR     where the program lives (default /opt/longreach)
  --python FILE    the interpreter it will run with, 3.11 or newer (default /usr/bin/python3)
  --from-venv DIR  take the libraries from this environment (for example .venv) instead of the package index; of an installed wheel
                   the program too, from the environment that it is in
TEXT
}

read_options() {
  while [ $# -gt 0 ]; do
    case $1 in
      --help) usage; exit 0 ;;
      --destdir | --prefix | --python | --from-venv)
        [ $# -ge 2 ] || { usage >&2; exit 2; }
        case $1 in
          --destdir) destdir=$(staging "$2") ;;
          --prefix) prefix=${2%/} ;;
          --python) python=$2 ;;
          --from-venv) from_venv=$2 ;;
        esac
        shift 2 ;;
      *) usage >&2; exit 2 ;;
    esac
  done
}

# The unit runs with ProtectHome=yes: what lies in a home directory does not exist for the service.
refuse_home() {
  case $2/ in
    /home/* | /root/* | /run/user/*) refuse "$1 is $2, in a home directory, which the service cannot see." "$3" ;;
  esac
}

check_python() {
  [ -x "$python" ] || refuse "the interpreter $python does not exist." "Install Python 3.11 or newer, or give --python FILE."
  "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    refuse "$python is $("$python" --version); 3.11 or newer is needed." "Give --python FILE."
  refuse_home "the interpreter" "$("$python" -c 'import sys; print(sys.base_prefix)')" "Give --python with a system-wide interpreter."
}

check_venv() {
  [ -n "$from_venv$checkout" ] || refuse "this copy was installed from a wheel." "Run the command beside it: longreach service install"
  [ -n "$from_venv" ] || return 0
  [ -x "$from_venv/bin/python" ] || refuse "$from_venv is no virtual environment." "Make one with \`make venv\`, or leave --from-venv away."
  local theirs ours version='import sysconfig; print(sysconfig.get_python_version())'
  theirs=$("$from_venv/bin/python" -c "$version") ours=$("$python" -c "$version")
  [ "$theirs" = "$ours" ] || refuse "$from_venv is for Python $theirs and $python is $ours." "Give --python with a Python $theirs."
}

# A complete new environment beside the old one, moved into place in the end: a failed installation leaves the old one working.
build_environment() {
  local new=$destdir$prefix.new work
  work=$(mktemp -d)
  trap "rm -rf '$work' '$new'" EXIT
  rm -rf "$new"
  mkdir -p "$new" 2>/dev/null ||
    refuse "$destdir$prefix cannot be made: no new folder can be in $(dirname "$new")." "Give --prefix or --destdir a DIR on a disk that can be written."
  if [ -z "$checkout" ]; then
    copy_installed "$new" "$work" --whole
    "$new/bin/python" "$here/console_scripts.py"
  else
    copy_source "$work/source"
    if [ -n "$from_venv" ]; then copy_libraries "$new" "$work"; else fetch_libraries "$new" "$work"; fi
  fi
  "$new/bin/python" -m compileall -q -j 0 "$new/lib" >/dev/null || true # test files of libraries may be for other Pythons
  say_final_place "$new"
  rm -rf "$destdir$prefix"
  mv "$new" "$destdir$prefix"
}

copy_source() {
  mkdir -p "$1"
  tar -C "$checkout" --exclude=./.venv --exclude=./.git --exclude=./build --exclude='*.egg-info' --exclude=__pycache__ -cf - . |
    tar -C "$1" -xf -
  # The installed copy has no history to ask; every log names the commit.
  git -C "$checkout" describe --always --abbrev=12 --dirty=+ --exclude='*' >"$1/daemon/commit.txt" 2>/dev/null ||
    rm -f "$1/daemon/commit.txt"
}

# The lock is a constraint here and not a list: it also names the development tools.
fetch_libraries() {
  "$python" -m venv "$1" || refuse "$python cannot make a virtual environment." "Install python3-venv."
  "$1/bin/pip" install --quiet --disable-pip-version-check --constraint "$2/source/requirements.lock" "$2/source"
}

copy_installed() {
  "$python" -m venv --without-pip "$1"
  local theirs ours place='import sysconfig; print(sysconfig.get_path("purelib"))'
  theirs=$("$from_venv/bin/python" -c "$place") ours=$("$1/bin/python" -c "$place")
  "$from_venv/bin/python" "$here/runtime_files.py" "${@:3}" >"$2/files"
  tar -C "$theirs" -T "$2/files" -cf - | tar -C "$ours" --no-same-owner -xf -
}

copy_libraries() {
  copy_installed "$1" "$2"
  local pip=("$from_venv/bin/python" -m pip --disable-pip-version-check)
  "${pip[@]}" wheel --quiet --no-deps --no-build-isolation --wheel-dir "$2" "$2/source"
  "${pip[@]}" --python "$1/bin/python" install --quiet --no-deps --no-index "$2"/longreach-*.whl
}

# Scripts carry the path of their interpreter.
say_final_place() {
  rm -f "$1"/bin/[Aa]ctivate*
  grep -IlrF -- "$1" "$1/bin" "$1/pyvenv.cfg" | xargs -r sed -i "s|$1|$prefix|g"
}

install_file() {
  install -D -m 0644 "$here/$1" "$destdir$2"
  echo "  wrote $destdir$2"
}

keep_or_install() {
  if [ -e "$destdir$2" ]; then echo "  kept  $destdir$2"; else install_file "$1" "$2"; fi
}

install_files() {
  install_file longreachd.service "$unit"
  install_file longreach-reports.service "$reports"
  sed -i "s|/opt/longreach/|$prefix/|g" "$destdir$unit" "$destdir$reports"
  install_file sysusers.d/longreach.conf "$sysusers"
  install_file tmpfiles.d/longreach.conf "$tmpfiles"
  install_file udev/70-longreach.rules "$udev"
  keep_or_install network/10-can0.network "$network"
  keep_or_install network/10-can0.link "$link"
  keep_or_install ../../config/rigs/ornl_testbed.yaml "$rig"
  mkdir -p "$destdir$(dirname "$command")"
  ln -sfn "$prefix/bin/longreach" "$destdir$command"
  echo "  wrote $destdir$command"
}

activate() {
  systemd-sysusers "$sysusers"
  systemd-tmpfiles --create "$tmpfiles"
  if systemd_runs; then systemctl daemon-reload; fi
  if command -v udevadm >/dev/null; then
    { udevadm control --reload && udevadm trigger --sysname-match=cpu_dma_latency; } 2>/dev/null || true
  fi
}

next_step() {
  cat <<TEXT
longreach is installed. Next:
  1. put your rig into $rig (now: $(sed -n 's/^name: *//p' "$rig"), simulated) and try: longreach check $rig
  2. usermod -aG longreach SOMEBODY        operators: they may use the socket and read the logs
  3. systemctl enable --now longreachd     it comes up disarmed
  4. systemctl enable --now longreach-reports   if you want a page of every run and fault beside its log
TEXT
}

read_options "$@"
check_root "installing writes to $prefix and /etc and makes a user" "$(with_root install)"
check_prefix
check_python
check_venv
check_stopped
build_environment
echo "  wrote $destdir$prefix ($("$python" --version))"
install_files
if [ -n "$destdir" ]; then
  echo "longreach is staged in $destdir; users, directories and units are activated by whoever unpacks it."
else
  activate
  next_step
fi

#!/bin/sh
# Put this folder's programs into the desktop's menu and make them open .bvh files, for this user;
# PREFIX=/usr/local as root does it for all. `install.sh --remove` takes it back. No file that is
# not ours is touched; the folder itself stays where it is.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
if [ -n "${PREFIX:-}" ]; then
    share=$PREFIX/share bin=$PREFIX/bin
else
    share=${XDG_DATA_HOME:-$HOME/.local/share} bin=$HOME/.local/bin
fi
entry=$share/applications/twist-inspector.desktop
mime=$share/mime/packages/twist-inspector.xml
icon=$share/icons/hicolor/scalable/apps/twist-inspector.svg

refresh() {
    for tool in "update-desktop-database $share/applications" "update-mime-database $share/mime"; do
        # shellcheck disable=SC2086  # two words
        if command -v "${tool%% *}" >/dev/null 2>&1; then $tool >/dev/null 2>&1 || true; fi
    done
}

# A link of an earlier bundle, also of one that was deleted since, is ours; all else is not.
for program in twist-inspector twistcore; do
    link=$bin/$program
    target=$(readlink "$link" || true)
    if [ -e "$link" ] && [ ! -e "$(dirname "${target:-/}")/share/twist-inspector.desktop" ]; then
        echo "$link is there and not ours; take it away first." >&2
        exit 1
    fi
done
if [ "${1:-}" = --remove ]; then
    rm -f "$entry" "$mime" "$icon" "$bin/twist-inspector" "$bin/twistcore"
    refresh
    echo "Twist Inspector is out of the menu; $here can be deleted."
    exit 0
fi
mkdir -p "$(dirname "$entry")" "$(dirname "$mime")" "$(dirname "$icon")" "$bin"
sed "s|^Exec=.*|Exec=\"$here/twist-inspector\" %f|" "$here/share/twist-inspector.desktop" >"$entry"
cp "$here/share/twist-inspector-mime.xml" "$mime"
cp "$here/share/twist-inspector.svg" "$icon"
ln -sfn "$here/twist-inspector" "$bin/twist-inspector"
ln -sfn "$here/twistcore" "$bin/twistcore"
refresh
echo "Twist Inspector is in the menu; $bin has twist-inspector and twistcore."

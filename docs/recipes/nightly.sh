#!/bin/sh
# One night for cron: prints nothing after exit code 0, else the reason and what barchain said.
# Set the paths; add `--plan FILE` for a plan of your own. The page is /srv/nights/nights/nightly.html.
# `flock` keeps a second night from beginning beside the first one. `timeout` ends a night that hangs, as by Ctrl-C: keep its
# limit well above the plan's minutes.
cd /srv/nights || exit 2
site= # folder that your web server has, e.g. /srv/www/nights: the results page goes there
link= # its address
chat= # address of an incoming webhook of a chat (Slack, Mattermost, Rocket.Chat, ...): it gets a few lines
build= # command that builds your programs, e.g. "cc -O2 -o engine engine.c -lm"
options="--fail-on worse" # or: changed, not-pass
[ -e begun ] && options="$options --require-history" # a lost history is told
if [ -n "$build" ] && ! said=$(sh -c "$build" 2>&1); then
  echo "A program was not built: no night began."
  echo "$said"
  exit 2
fi
touch started
said=$(flock -n -E 75 lock timeout -s INT -k 60 60m /srv/barchain/bin/barchain -q nightly --out nights $options 2>&1)
code=$?
[ -d nights ] && touch begun
if [ nights/nightly.json -nt started ]; then # tonight's
  [ -z "$site" ] || /srv/barchain/bin/barchain history site --out "$site" >/dev/null
  [ -z "$chat" ] || /srv/barchain/bin/barchain history tell ${link:+--link "$link"} |
    python3 -c 'import json, sys; print(json.dumps({"text": sys.stdin.read()}))' |
    curl --fail --silent --show-error --header "Content-Type: application/json" --data-binary @- "$chat" >/dev/null
fi
case $code in
  0) exit 0 ;;
  75) echo "The last night still runs: no night began."; exit 75 ;;
  124|137) echo "The night was ended after 60 minutes." ;;
  *) echo "The night ended with exit code $code." ;;
esac
echo "$said"
exit $code

#!/bin/sh
# One night for cron: prints nothing after exit code 0, else the reason and what barchain said.
# Set the paths; add `--plan FILE` for a plan of your own. The page is /srv/nights/nights/nightly.html.
# `flock` keeps a second night from beginning beside the first one. `timeout` ends a night that hangs, as by Ctrl-C: keep its
# limit well above the plan's minutes.
# To tell a chat, send it what `barchain history tell --link https://example.org/nightly.html` prints: lines of at most 200
# characters. For a phone, copy nights/nightly.html to where your web server has it: the page loads nothing.
cd /srv/nights || exit 2
options="--fail-on worse" # or: changed, not-pass
[ -e begun ] && options="$options --require-history" # a lost history is told
said=$(flock -n -E 75 lock timeout -s INT -k 60 60m /srv/barchain/bin/barchain -q nightly --out nights $options 2>&1)
code=$?
[ -d nights ] && touch begun
case $code in
  0) exit 0 ;;
  75) echo "The last night still runs: no night began."; exit 75 ;;
  124|137) echo "The night was ended after 60 minutes." ;;
  *) echo "The night ended with exit code $code." ;;
esac
echo "$said"
exit $code

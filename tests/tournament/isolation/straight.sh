# Drives to the nearest target, in POSIX shell and awk: it stands at the 11th and 12th numbers of the view, forward and
# left, and the 13th says whether there is one (docs/observation.md).
while read -r line; do
    case $line in
        '{"hello"'*) echo '{"control":"velocity"}' ;;
        '{"reset"'*) echo '{"ready":true}' ;;
        *) echo "${line#*[}" | awk -F, '{
            turn = $12 > 0 ? 1 : -1
            if ($11 > 0 && $12 * $12 < $11 * $11 / 100) turn = 10 * $12 / $11
            speed = $11 > 0 && $12 * $12 < $11 * $11
            printf "{\"action\":[%d,%f]}\n", $13 * speed, $13 * turn
        }' ;;
    esac
done

# The nearest target, in POSIX shell: rank 1 where the mask allows it.
# Lines in: {"hello":1}, then {"reset":{...}}, then {"view":[...],"mask":[1, 1, 0, ...]} for each step.
while read -r line; do
    case $line in
        '{"hello"'*) echo '{"control":"target"}' ;;
        '{"reset"'*) echo '{"ready":true}' ;;
        *'"mask":[1, 1'*) echo '{"action":1}' ;;
        *) echo '{"action":0}' ;;
    esac
done

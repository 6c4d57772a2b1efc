# answers without end, and never reads a line
echo '{"control":"target"}'
sleep 3600

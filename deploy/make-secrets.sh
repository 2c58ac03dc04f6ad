#!/bin/sh
# Make the secrets that docker-compose.yml reads: random, in a folder that only you may enter. Existing ones stay.
set -eu
folder="${1:-secrets}"
if [ -e "$folder/database_url" ]; then
    echo "$folder holds secrets already; nothing was changed" >&2
    exit 0
fi
umask 077
mkdir -p "$folder"
draw() { od -An -N24 -tx1 /dev/urandom | tr -d ' \n'; }
database=$(draw) broker=$(draw) key=$(draw) secret=$(draw)
printf '%s' "$database" > "$folder/database_password"
printf 'postgresql://garmentq:%s@database:5432/garmentq' "$database" > "$folder/database_url"
printf '%s' "$broker" > "$folder/broker_password"
printf 'redis://:%s@broker:6379/0' "$broker" > "$folder/broker_url"
printf '[default]\naws_access_key_id = %s\naws_secret_access_key = %s\n' "$key" "$secret" > "$folder/s3_credentials"
printf '{"identities": [{"name": "garmentq", "credentials": [{"accessKey": "%s", "secretKey": "%s"}], "actions": ["Admin", "Read", "Write", "List"]}]}\n' \
    "$key" "$secret" > "$folder/s3_config"
chmod 444 "$folder"/*  # the containers' users read them; the folder keeps other users of this machine out

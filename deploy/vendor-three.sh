#!/bin/sh
# Make the one bundle of three.js that the pages load. Only who changes its version needs npm; nothing here runs at install.
set -eu
three=0.187.0 esbuild=0.28.2
here=$(cd "$(dirname "$0")" && pwd)
out="$here/../service/pages/static/vendor"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$here/three.entry.js" "$folder/entry.js"
cd "$folder"
npm init -y > npm.log
npm install --ignore-scripts "three@$three" "esbuild@$esbuild" >> npm.log
line="esbuild entry.js --bundle --minify --format=esm --target=es2022 --legal-comments=inline --outfile=three-$three.js"
node_modules/@esbuild/*/bin/$line
cp "three-$three.js" "$out/"
cp node_modules/three/LICENSE "$out/three-$three.LICENSE.txt"
hash=$(sha256sum "three-$three.js" | cut -d' ' -f1)
entry=$(sha256sum entry.js | cut -d' ' -f1)
cat > "$out/three-$three.json" <<END
{
 "package": "three", "version": "$three", "licence": "MIT", "source": "https://www.npmjs.com/package/three/v/$three",
 "made_by": "deploy/vendor-three.sh with esbuild $esbuild",
 "build": "$line",
 "entry_sha256": "$entry",
 "sha256": "$hash"
}
END

"""Edit a result's pattern: drape it from where its garment hangs, judge it, and compare it with the recovered one."""

#!/bin/sh
# Renders the towns, decodes all data sets and computes triplets and motion labels into $DSFEAT_CACHE. Finished parts are skipped.
# Usage: DSFEAT_TRAINING=... DSSLAM_DATA=... DSFEAT_TOWNS=... DSFEAT_CACHE=... ./prepare.sh WEIGHTS
set -eu
weights=$1
python=${PYTHON:-python}
dsslam=${DSSLAM:-dsslam}
mkdir -p "$DSFEAT_TOWNS" "$DSFEAT_CACHE"

render() { # preset seed frames rounds
    [ -e "$DSFEAT_TOWNS/$1_$2/poses.txt" ] ||
        "$dsslam" synth "$DSFEAT_TOWNS/$1_$2" --preset "$1" --seed "$2" --frames "$3" --rounds "$4" --masks
}
render busy 201 400 1
render crossing 202 300 1
render town 203 1796 2
render busy 204 200 1
render busy 901 100 1
render crossing 902 100 1
render town 903 100 1

roads="cityscapes_train cityscapes_val idd_train idd_val camvid_train camvid_val camvid_test kitti_train kitti_val"
towns="town_busy_201 town_crossing_202 town_busy_901 town_crossing_902 town_town_903"
"$python" -m dsfeat.data --sets $roads $towns

loops=$DSFEAT_CACHE/triplets_town203.csv
[ -e "$loops" ] || "$python" -m dsfeat.prepare loops --sequence "$DSFEAT_TOWNS/town_203/image_0" --root "$DSFEAT_TOWNS" \
    --step 6 --xfeat "$weights/xfeat.onnx" --out "$loops"
[ -e "$DSFEAT_CACHE/triplets.npz" ] || "$python" -m dsfeat.prepare triplets --xfeat "$weights/xfeat.onnx" --csv \
    "$loops:$DSFEAT_TOWNS:90" "$DSFEAT_TRAINING/triplets_camvid.csv:$DSFEAT_TRAINING:120" "$DSFEAT_TRAINING/triplets_kitti03.csv:$DSSLAM_DATA:50"
[ -e "$DSFEAT_CACHE/motion.npz" ] || "$python" -m dsfeat.prepare motion --sequence \
    "$DSFEAT_TOWNS/busy_201:4" "$DSFEAT_TOWNS/crossing_202:4" "$DSFEAT_TOWNS/town_203:12" "$DSFEAT_TOWNS/busy_204:5"
# Only to evaluate: points on moving and on standing vehicles of two real sequences.
[ -e "$DSFEAT_CACHE/vehicles.npz" ] || "$python" -m dsfeat.prepare vehicles --names kittiraw_0005 kittiraw_1405 --step 2

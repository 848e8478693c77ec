#!/bin/sh
# Renders the towns, decodes all datasets and computes triplets, motion labels and the teachers' outlines into $DSFEAT_CACHE.
# Finished parts are skipped. ONLY=two prepares only what the network with two answers needs.
# Usage: DSFEAT_TRAINING=... DSSLAM_DATA=... DSFEAT_TOWNS=... DSFEAT_CACHE=... ./prepare.sh WEIGHTS
# FRAMES=16 takes at most that many frames of each town and of each folder that the teachers outline: a quick trial of all steps.
set -eu
weights=$1
python=${PYTHON:-python}
dsslam=${DSSLAM:-dsslam}
most=${FRAMES:-100000}
if [ "$most" -lt 9 ] && [ "${ONLY:-}" != two ]; then
    echo "prepare.sh: FRAMES is $most; motion labels need at least 9 frames of each town" >&2
    exit 2
fi
mkdir -p "$DSFEAT_TOWNS" "$DSFEAT_CACHE"

render() { # preset seed frames rounds
    [ -e "$DSFEAT_TOWNS/$1_$2/poses.txt" ] || "$dsslam" synth "$DSFEAT_TOWNS/$1_$2" --preset "$1" --seed "$2" \
        --frames $(($3 < most ? $3 : most)) --rounds "$4" --masks
}
traffic() { # courses whose view traffic fills; seed 71 only measures
    for seed in 101 102 103; do
        for preset in jam lorry column trams; do render "$preset" "$seed" 150 1; done
    done
    for seed in 104 105; do
        for preset in lorry trams; do render "$preset" "$seed" 150 1; done
    done
    for preset in jam lorry column trams; do render "$preset" 71 300 1; done
}
two() { # every n-th frame of a rendered town
    outlines=$DSFEAT_CACHE/outlines
    images="" maps=""
    for source in kt3dmoseg semantickitti parked davis; do
        images="$images $DSFEAT_TRAINING/motion/train/$source/image" maps="$maps $outlines/$source"
    done
    for drive in kittiraw_0926_0009 kitti_alike sfnd_kitti_mono78_rgb; do
        images="$images $DSFEAT_TRAINING/kitti_pseudo/$drive/image" maps="$maps $outlines/$drive"
    done
    "$python" -m dsfeat.teachers --teachers "$DSFEAT_TRAINING/teachers" --images $images --out $maps --most "$most"
    [ -e "$DSFEAT_CACHE/streets.done" ] || "$python" -m dsfeat.streets --outlines "$outlines" --states "$(dirname "$0")/states.csv" --step "$1" --most "$most"
    touch "$DSFEAT_CACHE/streets.done"
}
if [ "${ONLY:-}" = two ]; then
    render busy 204 40 1
    traffic
    [ -e "$DSFEAT_CACHE/triplets.npz" ] || "$python" -m dsfeat.prepare triplets --xfeat "$weights/xfeat.onnx" --csv \
        "$DSFEAT_TRAINING/triplets_camvid.csv:$DSFEAT_TRAINING:40" "$DSFEAT_TRAINING/triplets_kitti03.csv:$DSSLAM_DATA:20"
    two 1
    exit
fi
# To train: in `motion` each with the step of its frames. A truck fills the view in frames 50 to 130 of the crossing towns.
render busy 201 400 1
render crossing 202 300 1
render town 203 1796 2
render busy 204 200 1
motion="busy_201:4 crossing_202:4 town_203:12 busy_204:4"
for town in busy_211 crossing_212 town_213 busy_214 crossing_215 quiet_216 town_217 busy_218 crossing_219 town_220 busy_221 crossing_222; do
    preset=${town%_*}
    case $preset in crossing) frames=130 ;; quiet) frames=60 ;; *) frames=120 ;; esac
    render "$preset" "${town#*_}" "$frames" 1
    motion="$motion $town:3"
done
# To evaluate only: 901 to 903 were looked at while settings were chosen, 911 to 914 were not.
held="busy_901 crossing_902 town_903 busy_911 crossing_912 town_913 quiet_914"
for town in $held; do
    preset=${town%_*}
    case $town in crossing_912) frames=130 ;; *) frames=100 ;; esac
    render "$preset" "${town#*_}" "$frames" 1
done

sets="cityscapes_train cityscapes_val idd_train idd_val camvid_train camvid_val camvid_test kitti_train kitti_val"
for town in busy_201 crossing_202 $held; do sets="$sets town_$town"; done
"$python" -m dsfeat.data --sets $sets

loops=$DSFEAT_CACHE/triplets_town203.csv
[ -e "$loops" ] || "$python" -m dsfeat.prepare loops --sequence "$DSFEAT_TOWNS/town_203/image_0" --root "$DSFEAT_TOWNS" \
    --step 6 --xfeat "$weights/xfeat.onnx" --out "$loops"
[ -e "$DSFEAT_CACHE/triplets.npz" ] || "$python" -m dsfeat.prepare triplets --xfeat "$weights/xfeat.onnx" --csv \
    "$loops:$DSFEAT_TOWNS:90" "$DSFEAT_TRAINING/triplets_camvid.csv:$DSFEAT_TRAINING:120" "$DSFEAT_TRAINING/triplets_kitti03.csv:$DSSLAM_DATA:50"
if [ ! -e "$DSFEAT_CACHE/motion.npz" ]; then
    folders=""
    for entry in $motion; do folders="$folders $DSFEAT_TOWNS/$entry"; done
    "$python" -m dsfeat.prepare motion --sequence $folders
fi
# Only to evaluate: points on moving and on standing vehicles of two real sequences.
[ -e "$DSFEAT_CACHE/vehicles.npz" ] || "$python" -m dsfeat.prepare vehicles --names kittiraw_0005 kittiraw_1405 --step 2
traffic
two 5

//! Seeds of calibrations, one of each format and spelling that is read.

/// A camera of Kalibr's chain with its place.
fn kalibr(name: &str, place: &str) -> String {
    format!(
        "{name}:\n{place}  cam_overlaps: [1]\n  camera_model: pinhole\n  distortion_coeffs: [-0.1, 0.01, 0.001, 0.002]\n  \
         distortion_model: radtan\n  intrinsics: [30.0, 31.0, 19.0, 9.5]\n  resolution: [40, 20]\n  rostopic: /a\n"
    )
}

fn chain(field: &str, places: [f64; 2]) -> String {
    let place = |x: f64| {
        format!(
            "  {field}:\n  - [1.0, 0, 0, {x}]\n  - [0, 1.0, 0, 0]\n  - [0, 0, 1.0, 0]\n  - [0, 0, 0, 1.0]\n"
        )
    };
    let first = if field == "T_cn_cnm1" { String::new() } else { place(places[0]) };
    kalibr("cam0", &first) + &kalibr("cam1", &place(places[1]))
}

fn camera_info(model: &str, coefficients: &str) -> String {
    format!(
        "image_width: 40\nimage_height: 20\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [30, 0, 19, 0, 31, 9.5, 0, \
         0, 1]\ndistortion_model: {model}\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [{coefficients}]\n\
         rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nprojection_matrix:\n  rows: 3\n  cols: \
         4\n  data: [30, 0, 19, -7.5, 0, 31, 9.5, 0, 0, 0, 1, 0]\n"
    )
}

/// The name's number in `files::CALIBRATIONS`, and the text.
pub(super) fn all() -> Vec<(u8, String)> {
    let fixed = [
        (0, OWN),
        (1, SENSOR),
        (2, BOOFCV),
        (5, KITTI),
        (5, KITTI_RAW),
        (0, SETTINGS_2),
        (0, SETTINGS_2_RAW),
        (0, SETTINGS_3),
        (0, OPENCV_YAML),
        (0, OPENCV_STEREO),
        (2, OPENCV_XML),
        (3, OPENCV_JSON),
        (3, NERFSTUDIO),
        (3, REPLICA),
        (3, REALSENSE),
        (0, LAB),
        (4, COLMAP),
    ];
    let made = [
        chain("T_cn_cnm1", [0.0, -0.25]),
        chain("T_cam_imu", [0.5, 0.25]),
        chain("T_imu_cam", [0.5, 0.75]),
        camera_info("plumb_bob", "-0.1, 0.01, 0.001, 0.002, 0"),
        camera_info("rational_polynomial", "0.5, -2.5, 0.001, -0.002, 1.5, 0.25, -2, 1.25"),
        camera_info("equidistant", "0.01, 0.02, 0.03, 0.04"),
    ];
    fixed.map(|(kind, text)| (kind, text.to_owned())).into_iter().chain(made.map(|text| (0, text))).collect()
}

pub(super) const OWN: &str = "fps: 30\ndepth_units_per_metre: 1000\nbaseline_m: 0.08\ncameras:\n  - model: pinhole-radtan\n    resolution: [64, 48]\n    intrinsics: [45.8, 45.7, 32.5, 23.5]\n    distortion: [-0.28, 0.07, 0.0, 0.0]\n  - model: none\n    resolution: [64, 48]\n    intrinsics: [45.7, 45.6, 31.2, 24.0]\nright_from_left:\n  - [1, 0, 0, -0.11]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n";
pub(super) const SENSOR: &str = "T_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\nresolution: [40, 40]\ncamera_model: pinhole\nintrinsics: [30.0, 30.0, 20.0, 20.0]\ndistortion_model: radial-tangential\ndistortion_coefficients: [0.1, 0.0, 0.0, 0.0]\n";
pub(super) const KITTI: &str = "P0: 70 0 20 0 0 70 20 0 0 0 1 0\nP1: 70 0 20 -38 0 70 20 0 0 0 1 0\n";
pub(super) const KITTI_RAW: &str = "calib_time: 09-Jan-2012 14:00:15\ncorner_dist: 9.950000e-02\nS_rect_00: 4.0e+01 4.0e+01\nR_rect_00: 1 0 0 0 1 0 0 0 1\nP_rect_00: 30 0 19 0 0 31 9.5 0 0 0 1 0\nP_rect_01: 30 0 19 -7.5 0 31 9.5 0 0 0 1 0\n";
const BOOFCV: &str = "<?xml version=\"1.0\"?><boofcv.struct.calib.StereoParameters><left><width>64</width><height>48</height><fx>45</fx><fy>45</fy><skew>0</skew><cx>32</cx><cy>24</cy><radial><double>-0.3</double><double>0.1</double></radial><t1>0</t1><t2>0</t2></left><right><width>64</width><height>48</height><fx>45</fx><fy>45</fy><skew>0</skew><cx>32</cx><cy>24</cy></right><rightToLeft><r><numRows>3</numRows><data><double>1</double><double>0</double><double>0</double><double>0</double><double>1</double><double>0</double><double>0</double><double>0</double><double>1</double></data></r><t><x>0.1</x><y>0</y><z>0</z></t></rightToLeft></boofcv.struct.calib.StereoParameters>";
const SETTINGS_2: &str = "%YAML:1.0\n---\nCamera.type: \"PinHole\"\nCamera.fx: 458.6\nCamera.fy: 457.2\nCamera.cx: 367.2\nCamera.cy: 248.3\nCamera.k1: -0.28\nCamera.width: 752\nCamera.height: 480\nCamera.fps: 20.0\nCamera.bf: 47.9\nDepthMapFactor: 5000.0\n";
const SETTINGS_2_RAW: &str = "%YAML:1.0\nLEFT.height: 20\nLEFT.width: 40\nLEFT.D: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [-0.1, 0.01, 0.001, 0.002, 0.0]\nLEFT.K: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [30.0, 0.0, 19.0, 0.0, 31.0, 9.5, 0.0, 0.0, 1.0]\nLEFT.R: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\nRIGHT.height: 20\nRIGHT.width: 40\nRIGHT.D: {data: [-0.1, 0.01, 0.001, 0.002, 0.0]}\nRIGHT.K: {data: [30.0, 0.0, 19.0, 0.0, 31.0, 9.5, 0.0, 0.0, 1.0]}\nRIGHT.R: {data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\nRIGHT.P: {data: [30, 0, 19, -7.5, 0, 31, 9.5, 0, 0, 0, 1, 0]}\n";
const SETTINGS_3: &str = "%YAML:1.0\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\nCamera1.fx: 30.0\nCamera1.fy: 31.0\nCamera1.cx: 19.0\nCamera1.cy: 9.5\nCamera1.k1: -0.1\nCamera2.fx: 30.0\nCamera2.fy: 31.0\nCamera2.cx: 19.0\nCamera2.cy: 9.5\nCamera.width: 40\nCamera.height: 20\nCamera.fps: 20\nStereo.ThDepth: 60.0\nStereo.b: 0.25\nRGBD.DepthMapFactor: 5000.0\nStereo.T_c1_c2: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: f\n  data: [1, 0, 0, 0.25, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1.0]\n";
const OPENCV_YAML: &str = "%YAML:1.0\n---\nimage_width: 40\nimage_height: 20\nK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 30., 0., 19., 0., 31., 9.5000000000000000e+00,\n       0., 0., 1. ]\nD: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ -0.1, 0.01, 0.001, 0.002, 0. ]\n";
const OPENCV_STEREO: &str = "image_size: [40, 20]\nM1: {data: [30, 0, 19, 0, 31, 9.5, 0, 0, 1]}\nD1: {data: [-0.1, 0.01, 0.001, 0.002, 0]}\nM2: {data: [30, 0, 19, 0, 31, 9.5, 0, 0, 1]}\nD2: {data: [-0.1, 0.01, 0.001, 0.002, 0]}\nR: {data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\nT: {data: [-0.25, 0, 0]}\n";
const OPENCV_XML: &str = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>40</image_width>\n<image_height>20</image_height>\n<K type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>3</cols>\n  <dt>d</dt>\n  <data>\n    30. 0. 19. 0. 31. 9.5 0.\n    0. 1.</data></K>\n<D type_id=\"opencv-matrix\">\n  <rows>1</rows><cols>5</cols><dt>d</dt>\n  <data>-0.1 0.01 0.001 0.002 0.</data></D>\n</opencv_storage>\n";
const OPENCV_JSON: &str = "{\n    \"image_width\": 40,\n    \"image_height\": 20,\n    \"K\": {\n        \"type_id\": \"opencv-matrix\",\n        \"rows\": 3, \"cols\": 3, \"dt\": \"d\",\n        \"data\": [ 30.0, 0.0, 19.0, 0.0, 31.0, 9.5, 0.0, 0.0, 1.0 ]\n    },\n    \"D\": { \"type_id\": \"opencv-matrix\", \"data\": [ -0.1, 0.01, 0.001, 0.002, 0.0 ] }\n}\n";
const NERFSTUDIO: &str = "{\"fl_x\": 500.0, \"fl_y\": 500.0, \"cx\": 320.0, \"cy\": 240.0, \"w\": 640, \"h\": 480, \"k1\": 0.1, \"camera_model\": \"OPENCV\", \"frames\": []}";
pub(super) const REPLICA: &str = "{\"camera\": {\"w\": 40, \"h\": 40, \"fx\": 30.0, \"fy\": 31.0, \"cx\": 19.0, \"cy\": 9.5, \"scale\": 6553.5}}";
pub(super) const REALSENSE: &str = "{\"width\": 40, \"height\": 40, \"fx\": 30.0, \"fy\": 31.0, \"ppx\": 19.0, \"ppy\": 9.5, \"model\": \"inverse_brown_conrady\", \"coeffs\": [0, 0, 0, 0, 0], \"depth_scale\": 0.001}";
pub(super) const LAB: &str = "cameras:\n- {cam_name: rgb_0, cam_type: gray, cam_model: pinhole, distortion_type: radtan5, focal_length: [30, 31], principal_point: [19, 9.5], distortion_coefficients: [-0.1, 0.01, 0.001, 0.002, 0], image_dimension: [40, 40], fps: 20.0, depth_factor: 5000, T_BS: [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}\n";
const COLMAP: &str = "# Camera list\n1 FULL_OPENCV 40 20 30 31 19.5 10 0.5 -2.5 0.001 -0.002 1.5 0.25 -2 1.25\n2 OPENCV 640 480 500 500 320 240 0.1 0.0 0.0 0.0\n3 SIMPLE_RADIAL 40 20 30 19.5 10 -0.1\n";
/// A chain of TUM-VI.
pub(super) fn tum_vi() -> String {
    chain("T_cam_imu", [0.5, 0.25]).replace("[40, 20]", "[40, 40]")
}

//! x
use eval::*;
use std::path::Path;
#[test]
fn t() {
    let d = Path::new("/work/shared/reference/trajectories");
    let gt = read_trajectory_file(&d.join("KITTI_00_gt.txt"), None).unwrap().trajectory;
    for f in ["KITTI_00_ORB.txt", "KITTI_00_SPTAM.txt"] {
        let est = read_trajectory_file(&d.join(f), None).unwrap().trajectory;
        let p = associate(&est, &gt, Association::Index).unwrap();
        let dr = kitti_drift(&p.est, &p.gt, &KITTI_LENGTHS_M).unwrap();
        println!("{f} {:?} {:?} {:?} {:?} {}", dr.t_rel_percent, dr.r_rel_deg_per_100m, dr.rms, dr.std, dr.n_segments);
        for a in [Alignment::None, Alignment::Se3, Alignment::Sim3] {
            let r = ate(&p.est, &p.gt, a).unwrap();
            println!("{a} {}", r.rmse);
            let al = r.aligned(&p.est);
            let dr = kitti_drift(&al, &p.gt, &KITTI_LENGTHS_M).unwrap();
            println!("   {:?} {:?}", dr.t_rel_percent, dr.r_rel_deg_per_100m);
            eval::plot::trajectory_png(Path::new(&format!("/work/tmp/evalws/scratch/{f}.{a}.png")), &al, &p.gt, "KITTI 00, ORB-SLAM2 stereo").unwrap();
        }
    }
    let gt = read_trajectory_file(&d.join("fr2_desk_groundtruth.txt"), None).unwrap().trajectory;
    for f in ["fr2_desk_ORB.txt", "fr2_desk_ORB_kf_mono.txt"] {
        let est = read_trajectory_file(&d.join(f), None).unwrap().trajectory;
        let p = associate(&est, &gt, Association::Timestamp{tolerance_s: 0.01}).unwrap();
        for a in [Alignment::None, Alignment::Se3, Alignment::Sim3] {
            let r = ate(&p.est, &p.gt, a).unwrap();
            println!("{f} {a} {} {}", r.rmse, r.n);
            let al = r.aligned(&p.est);
            eval::plot::trajectory_png(Path::new(&format!("/work/tmp/evalws/scratch/{f}.{a}.png")), &al, &p.gt, "TUM fr2/desk").unwrap();
        }
    }
}

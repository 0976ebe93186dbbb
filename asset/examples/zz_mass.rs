
use asset::{orient::Scene, repair::repair, mass::weigh, materials::substance};
use object::*;
fn main(){ for case in std::env::args().skip(1){ let c=std::path::Path::new(&case);
 let t=std::time::Instant::now();
 let cond=Condition::from_json(&std::fs::read_to_string(c.join("condition.json")).unwrap()).unwrap();
 let mesh=glb::read(&std::fs::read(c.join("mesh.glb")).unwrap()).unwrap();
 let l:Vec<u16>=std::fs::read(c.join("face_labels.u16le")).unwrap().chunks_exact(2).map(|b|u16::from_le_bytes([b[0],b[1]])).collect();
 let s=cond.size.map_or(1.0,|s|s.scale_for(&mesh)); let mesh=mesh.map_vertices(|v|v*s).unwrap();
 let scene=Scene::new(&mesh); let mut total=0.0; let mut rep=[0;4]; let mut txt=String::new();
 for p in 0..cond.tree.len(){ let f:Vec<usize>=(0..l.len()).filter(|&f|l[f] as usize==p).collect(); if f.is_empty(){continue}
  let m=mesh.submesh(f).unwrap(); let r=repair(&m,scene.as_ref()).unwrap(); let sub=substance(&cond,Some(&cond.prompts[p]),&cond.tree.parts()[p].text,m.bounds().diagonal());
  let b=weigh(&r,&[],&sub); total+=b.mass.value; for (a,b) in rep.iter_mut().zip([r.report.degenerate,r.report.repeated,r.report.flipped,r.report.conflicts]){*a+=b}
  let cl:f64=r.patches.iter().filter(|p|p.volume.is_some()).flat_map(|p|&p.faces).map(|&f|r.mesh.area(f as usize)).sum(); let al:f64=(0..r.mesh.faces().len()).map(|f|r.mesh.area(f)).sum();
  txt+=&format!(" {}={:.4}kg({},{:.0}%,{:.1}mm)",cond.tree.parts()[p].name,b.mass.value,sub.material.value,(cl/al).abs()*100.0,sub.wall.value*1e3);
 }
 println!("{} faces {} total {:.3} kg  [degen,rep,flip,conf]={:?} {:?}\n    {}",c.file_name().unwrap().to_str().unwrap(),mesh.faces().len(),total,rep,t.elapsed(),txt.chars().take(900).collect::<String>());
}}
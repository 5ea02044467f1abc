//! A structure on a GPU, and batches of rays on their way there and back.

use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

use slo_accel::glam::Vec3;
use slo_accel::study::{Answer, Counts};
use slo_accel::triangle::ShearedRay;
use slo_accel::{Rays, Triangle, Uploaded};
use wgpu::{BindGroupDescriptor, BindGroupEntry, Buffer, ComputePipeline, MapMode};

use crate::desk::{Desk, WORDS};
use crate::packed::{Frame, Packed};
use crate::program::GROUP;
use crate::shared::Shared;

/// Most rays of a dispatch: fewer than its groups may be, and little enough for any GPU's patience.
const MOST_RAYS: usize = 1 << 18;

/// A structure on a GPU.
#[derive(Debug)]
pub(crate) struct Resident {
    gpu: Arc<Shared>,
    program: ComputePipeline,
    frame: Frame,
    triangles: Buffer,
    references: Buffer,
    nodes: Buffer,
}

impl Resident {
    pub(crate) fn new(
        gpu: Arc<Shared>,
        packed: &Packed,
        triangles: &[Triangle],
    ) -> Result<Self, String> {
        gpu.failure.check()?;
        let words = |triangle: &Triangle| triangle.map(|p| p.to_array().map(f32::to_bits));
        let corners: Vec<u32> = triangles.iter().flat_map(words).flatten().collect();
        let triangles = gpu.buffer("triangles", &corners)?;
        let references = gpu.buffer("references", &packed.references)?;
        let nodes = gpu.buffer("nodes or cells", &packed.nodes)?;
        let program = gpu.program(packed.kind, packed.stack);
        gpu.failure.check()?;
        Ok(Self { gpu, program, frame: packed.frame, triangles, references, nodes })
    }

    /// Traces rays `from` and those that follow it, as many as fit a dispatch.
    fn dispatch(
        &self,
        desk: &Desk,
        rays: &Rays,
        from: usize,
        any: bool,
        answers: &mut Vec<Answer>,
    ) -> Result<(), String> {
        let Shared { device, queue, .. } = &*self.gpu;
        let count = (rays.len() - from).min(MOST_RAYS);
        let words: Vec<u32> = (from..from + count).flat_map(|i| words_of(rays, i)).collect();
        let bytes = (count * WORDS * 4) as u64;
        queue.write_buffer(&desk.rays, 0, bytemuck::cast_slice(&words));
        let query = self.frame.query(count as u32, any, self.gpu.most_rounds);
        queue.write_buffer(&desk.query, 0, &query);
        let buffers = [
            &desk.query,
            &desk.rays,
            &desk.answers,
            &self.triangles,
            &self.references,
            &self.nodes,
        ];
        let entries: Vec<BindGroupEntry<'_>> = (0u32..)
            .zip(buffers)
            .map(|(binding, buffer)| BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &self.program.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.program);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups((count as u32).div_ceil(GROUP), 1, 1);
        }
        encoder.copy_buffer_to_buffer(&desk.answers, 0, &desk.read_back, 0, bytes);
        let submitted = queue.submit([encoder.finish()]);
        let (done, is_done) = channel();
        desk.read_back.map_async(MapMode::Read, ..bytes, move |result| {
            // The thread waits for it.
            let _ = done.send(result.is_ok());
        });
        let wait = wgpu::PollType::Wait { submission_index: Some(submitted), timeout: None };
        device.poll(wait).map_err(|error| error.to_string())?;
        self.gpu.failure.check()?;
        // Another thread's wait may have finished this one's, and be about to say so.
        if !is_done.recv_timeout(Duration::from_secs(60)).unwrap_or(false) {
            return Err("its answers can't be read".to_owned());
        }
        let mapped = desk.read_back.get_mapped_range(..bytes).map_err(|error| error.to_string())?;
        answers.extend(mapped.chunks_exact(WORDS * 4).map(answer));
        drop(mapped);
        desk.read_back.unmap();
        Ok(())
    }
}

impl Uploaded for Resident {
    fn trace(&self, rays: &Rays, any: bool, answers: &mut Vec<Answer>) -> Result<(), String> {
        answers.clear();
        self.gpu.failure.check()?;
        let desk = self.gpu.desk(rays.len().min(MOST_RAYS))?;
        while answers.len() < rays.len() {
            let from = answers.len();
            self.dispatch(&desk, rays, from, any, answers).inspect_err(|reason| {
                // Buffers may be in any state: they are not put back.
                self.gpu.failure.note(reason.clone());
            })?;
        }
        self.gpu.put_back(desk);
        Ok(())
    }

    fn bytes(&self) -> usize {
        let buffers = [&self.triangles, &self.references, &self.nodes];
        buffers.iter().map(|buffer| buffer.size() as usize).sum()
    }
}

/// The words of a ray, as kernels/rays.wgsl has them.
fn words_of(rays: &Rays, i: usize) -> [u32; WORDS] {
    let (origin, direction) = (rays.origin(i), rays.direction(i));
    let ShearedRay { axes, shear, .. } = ShearedRay::new(origin, direction);
    let [o, d, s] =
        [origin, direction, Vec3::from_array(shear)].map(|v| v.to_array().map(f32::to_bits));
    let t_max = rays.t_max[i].to_bits();
    [o[0], o[1], o[2], t_max, d[0], d[1], d[2], axes[2] as u32, s[0], s[1], s[2], 0]
}

/// Reads an answer.
fn answer(bytes: &[u8]) -> Answer {
    let word = |i: usize| {
        let at = 4 * i;
        u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    };
    let [t, u, v] = [0, 1, 2].map(|i| f32::from_bits(word(i)));
    let wide = |i: usize| u64::from(word(i));
    let mut counts = Counts::default();
    (counts.steps, counts.boxes, counts.tests) = (wide(4), wide(5), wide(6));
    (counts.leaves, counts.empty_leaves, counts.restarts) = (wide(7), wide(8), wide(9));
    Answer { object: word(3), t, u, v, counts, is_certain: word(11) == 0 }
}

//! State of rigid bodies from step to step, in memory and in files.

use glam::DVec3;
use physcore_rigid::rotation::Orientation;
use physcore_rigid::world::{BodyRest, Turn};

use super::RigidBodies;
use crate::error::{Error, Result};
use crate::history::{Archive, History};
use crate::math::AXES;

/// History: orientations, angular momenta, torques, loads of contacts and joints, forces of ties, rests.
impl History for RigidBodies {
    fn save(&mut self) {
        self.saved.clone_from(&self.world.state);
    }

    fn rollback(&mut self) {
        self.world.state.clone_from(&self.saved);
    }

    fn capture(&self, archive: &mut Archive) {
        let turn = |turn: &Turn| {
            let Turn { orientation: Orientation { quaternion, angle }, spin } = turn;
            [quaternion.to_array().as_slice(), &[*angle], &spin.to_array()].concat()
        };
        archive.write("turns", self.world.state.turns.iter().flat_map(turn));
        archive.write("loads", self.world.state.packed_loads());
        archive.write("joints", self.world.state.packed_joints());
        archive.write("torn", [self.world.state.torn]);
        archive.write("ties", self.world.state.ties.iter().flat_map(DVec3::to_array));
        archive.write("torques", self.world.state.torques.iter().flat_map(DVec3::to_array));
        archive.write("pushed", [self.world.state.pushed]);
        if self.world.may_sleep() {
            archive.write("rests", self.world.state.rests.iter().flat_map(BodyRest::packed));
            archive.write("slept", [self.world.state.slept]);
        }
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let numbers = archive.read_exactly("turns", 8 * self.particles.len())?;
        for (turn, numbers) in self.world.state.turns.iter_mut().zip(numbers.chunks_exact(8)) {
            let [x, y, z, w, angle, spin @ ..] = numbers else { continue };
            let quaternion = glam::DQuat::from_xyzw(*x, *y, *z, *w);
            *turn = Turn { orientation: Orientation { quaternion, angle: *angle }, spin: DVec3::from_slice(spin) };
        }
        let loads = archive.read("loads")?.to_vec();
        let joints = archive.read("joints")?.to_vec();
        self.world.state.torn = archive.read_number("torn")?;
        let ties = archive.read_exactly("ties", AXES * self.world.state.ties.len())?;
        self.world.state.ties = ties.chunks_exact(AXES).map(DVec3::from_slice).collect();
        let torques = archive.read_exactly("torques", AXES * self.particles.len())?;
        self.world.state.torques = torques.chunks_exact(AXES).map(DVec3::from_slice).collect();
        self.world.state.pushed = archive.read_number("pushed")?;
        if self.world.may_sleep() {
            let rests = archive.read_exactly("rests", BodyRest::NUMBERS * self.particles.len())?;
            self.world.state.rests = rests.chunks_exact(BodyRest::NUMBERS).map(BodyRest::unpacked).collect();
            self.world.state.slept = archive.read_number("slept")?;
        }
        if self.world.state.unpack(&loads, &joints) {
            Ok(())
        } else {
            Err(Error::parameter("checkpoint.joints", "joints of this scene", "others"))
        }
    }
}

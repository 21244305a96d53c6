#pragma once

#include <filesystem>
#include <string>

#include "common/voxel/world.hpp"

namespace terravox::worlds {

/// A world as a server needs it: boxes that may be kept from one process to the next, and reports
/// of its state. Thread-safe, like every World.
class ServedWorld : public voxel::ProvenanceWorld {
public:
    /// What is served, for the user who starts the server: "a Minecraft world".
    [[nodiscard]] virtual std::string summary() const = 0;
    /// Starts opening on another thread where boxes of an earlier process can be served meanwhile.
    /// To be called once the server accepts requests. Idempotent.
    virtual void begin_opening() {}
    [[nodiscard]] virtual bool is_open() const noexcept { return true; }
    /// Why boxes can no longer be made; empty: boxes can be made, as far as is known.
    [[nodiscard]] virtual std::string failure() const = 0;
    /// Whether box() makes boxes of every level. Otherwise it makes those of level 0, and a coarser
    /// box is its eight children, downsampled.
    [[nodiscard]] virtual bool makes_all_levels() const noexcept = 0;
    /// Whether another process computes the same fingerprint() as long as the inputs are the same.
    /// Otherwise boxes are valid in this process alone.
    [[nodiscard]] virtual bool has_lasting_fingerprint() const noexcept { return true; }
    /// Whether its boxes come from another machine: they are then not prefetched.
    [[nodiscard]] virtual bool is_remote() const noexcept { return false; }
    /// The file of a world that is a box archive of this machine; else empty.
    [[nodiscard]] virtual std::filesystem::path archive_file() const { return {}; }
};

}  // namespace terravox::worlds

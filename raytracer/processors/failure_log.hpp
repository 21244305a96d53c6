#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "raytracer/tiles/tile.hpp"

namespace terravox::processors {

/// Which bands which members could not trace. When enough different ones fail at the same rows, it
/// is the picture that is at fault rather than they. Bands are cut anew when they go to others, so
/// rows are compared, not bands. Not thread-safe.
class FailureLog {
public:
    /// Rows that so many different members cannot trace, no member can.
    static constexpr std::size_t kMaxMembers = 3;

    /// @param who  the identity of the member; one that fails again and again counts once
    /// @return how many different members have failed at any of these rows so far
    std::size_t add(const tiles::RenderTile& band, const std::string& who);

private:
    struct Failure {
        tiles::RenderTile band;
        std::string who;
    };
    std::vector<Failure> m_failures;  ///< all different
};

}  // namespace terravox::processors

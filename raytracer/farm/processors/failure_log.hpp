#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::processors {

/// Records which members failed at which bands. When enough different members fail at the same
/// rows, the picture is at fault rather than they. Bands are cut anew when they are reassigned, so
/// rows are compared, not bands. Not thread-safe.
class FailureLog {
public:
    /// When this many different members fail at the same rows, the rows are considered untraceable.
    static constexpr std::size_t kMaxMembers = 3;

    /// @param identity of the member (MemberSpec::identity); one that fails repeatedly counts once
    /// @return number of different members that have failed at any of these rows so far
    std::size_t add(const tiles::RenderTile& band, const std::string& identity);

private:
    struct Failure {
        tiles::RenderTile band;
        std::string identity;
    };
    std::vector<Failure> m_failures;  ///< all different
};

}  // namespace terravox::processors

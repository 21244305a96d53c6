#pragma once

#include <laszip/laszip_api.h>
#include <xxhash.h>

#include <array>
#include <cstdint>
#include <memory>

namespace terravox::laz {

/// A fingerprint of a sequence of points: equal for a file and its compressed copy if every field
/// of every point is equal.
class PointDigest {
public:
    /// @param format  0-10, which determines the fields of a point
    explicit PointDigest(int format);
    void add(const laszip_point_struct& point);
    [[nodiscard]] std::uint64_t value() const noexcept { return XXH3_64bits_digest(m_state.get()); }

private:
    struct Free {
        void operator()(XXH3_state_t* state) const noexcept { XXH3_freeState(state); }
    };
    bool m_extended;
    bool m_time;
    bool m_colour;
    bool m_infrared;
    bool m_wave;
    std::unique_ptr<XXH3_state_t, Free> m_state;
};

}  // namespace terravox::laz

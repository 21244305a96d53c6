#pragma once

#include <cstddef>
#include <memory>

#include "tests/bench/entries/neutral_scene.hpp"

namespace terravox::bench {

/// The neutral scene as a mesh in Embree: every face between solid and air, runs of faces along z as one quad. Built only where Embree
/// 3 is installed.
class EmbreeScene {
public:
    /// @throws Error when Embree cannot start
    explicit EmbreeScene(const NeutralScene& scene);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    [[nodiscard]] std::size_t quads() const noexcept;
    /// The same rays as walk_view, one after the other on this thread. Steps are not known.
    [[nodiscard]] ViewTimes trace_view(const Camera& camera);

private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox::bench

#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "raytracer/preview/desk.hpp"
#include "raytracer/render/crew.hpp"

namespace terravox {

/// Who renders the preview: seen at work, and changed while it runs.
class ProcessorsPanel {
public:
    void draw(Desk& desk, Crew& crew);

private:
    struct Speed {
        std::uint64_t tiles = 0;  ///< when it was last asked for
        double tiles_per_s = 0;   ///< lately
    };
    void note_speeds(double passed_s);
    std::string m_address;
    std::vector<Crew::Hand> m_hands;
    std::map<ProcessorPool::MemberId, Speed> m_speeds;
    std::vector<std::string> m_dialled;
    std::chrono::steady_clock::time_point m_asked;
};

}  // namespace terravox

#include "raytracer/farm/cluster/tasks.hpp"

#include <algorithm>

namespace terravox::cluster {

int usual_per_task(int frames, int nodes) noexcept {
    constexpr int kTasksOfNode = 8;
    const int tasks = std::max(1, nodes) * kTasksOfNode;
    return std::max(1, (frames + tasks - 1) / tasks);
}

std::string array_text(const std::vector<int>& sorted) {
    std::string out;
    for (std::size_t i = 0; i < sorted.size();) {
        std::size_t end = i + 1;
        while (end < sorted.size() && sorted[end] == sorted[end - 1] + 1)
            ++end;
        out += (out.empty() ? "" : ",") + std::to_string(sorted[i]);
        if (end - i > 1)
            out += "-" + std::to_string(sorted[end - 1]);
        i = end;
    }
    return out;
}

std::vector<ArrayPiece> array_pieces(const std::vector<int>& tasks, int limit) {
    std::vector<ArrayPiece> out;
    for (const int task : tasks) {
        const int offset = task / limit * limit;
        if (out.empty() || out.back().offset != offset)
            out.push_back({offset, {}});
        out.back().indices.push_back(task - offset);
    }
    return out;
}

}  // namespace terravox::cluster

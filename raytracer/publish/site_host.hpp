#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace terravox::publish {

/// Serves the files of a site to browsers of this machine, with ranges and entity tags: for a look
/// before it goes to a host. Listens on the loopback address alone; refuses other names of it (DNS
/// rebinding) and requests that other pages make; lists no folders, runs nothing. Serves until it
/// is destroyed.
class SiteHost {
public:
    /// @param folder the site
    /// @param port 0: any that is free
    /// @throws Error when it cannot listen there
    SiteHost(const std::filesystem::path& folder, std::uint16_t port);
    ~SiteHost();
    SiteHost(const SiteHost&) = delete;
    SiteHost& operator=(const SiteHost&) = delete;

    /// Where the site is: "http://127.0.0.1:8080/".
    [[nodiscard]] std::string address() const;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox::publish

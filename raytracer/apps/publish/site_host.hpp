#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "voxelserver/serve/host/host.hpp"
#include "voxelserver/serve/http/request_check.hpp"

namespace terravox::publish {

/// Answers requests for the files of a folder, which may be a stranger's: nothing outside of it is
/// read, since no symbolic link is followed; no folder is listed, nothing is run. A folder shows
/// its index.html. Its pages may ask nobody but their host (http::add_page_headers). Addresses have
/// up to kMaxAddress_bytes. A function of the request and the folder, without sockets; thread-safe.
class SiteFiles : public http::RequestHandler {
public:
    static constexpr std::size_t kMaxAddress_bytes = 2048;

    /// @param archive_origin the one other origin that pages may ask, "https://HOST"; empty: none
    /// @throws Error for a folder that cannot be opened
    explicit SiteFiles(const std::filesystem::path& folder, std::string archive_origin = {});
    ~SiteFiles() override;

    [[nodiscard]] std::optional<http::Response> refusal(const http::Request& request) override;
    [[nodiscard]] http::Response handle(const http::Request& request) override;

private:
    [[nodiscard]] http::Response answer(const http::Request& request) const;

    http::RequestCheck m_check;
    const std::string m_archive_origin;
    const int m_folder;  ///< descriptor
};

/// Serves the files of a site to browsers of this machine, for a look before it goes to a host.
/// Listens on the loopback address alone; refuses other names of it (DNS rebinding) and requests
/// that other pages make. Serves until it is destroyed.
class SiteHost {
public:
    /// @param folder, archive_origin  as SiteFiles
    /// @param port 0: any that is free
    /// @throws Error when it cannot listen there, or the folder cannot be opened
    SiteHost(const std::filesystem::path& folder, std::uint16_t port,
             std::string archive_origin = {});

    /// Where the site is: "http://127.0.0.1:8080/".
    [[nodiscard]] std::string address() const { return m_host.url() + "/"; }

private:
    SiteFiles m_files;
    http::Host m_host;
};

}  // namespace terravox::publish

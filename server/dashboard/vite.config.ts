// Two files with names that stay: the server embeds them and answers with ETags.
export default {
  base: "/",
  // `npx vite` serves the sources as they are edited, before a server on this machine.
  server: { proxy: { "/v1": process.env.EVSWARM_SERVER ?? "http://127.0.0.1:8080" } },
  // Tests read the style sheet.
  test: { css: true },
  build: {
    outDir: "dist",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: false,
    cssCodeSplit: false,
    rollupOptions: {
      output: {
        entryFileNames: "dashboard.js",
        assetFileNames: "dashboard[extname]",
        inlineDynamicImports: true,
      },
    },
  },
};
